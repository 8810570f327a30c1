C     A crushable bed with memory: where a point has been before, it is crushed
C     and has a hundredth of its strength. The deepest z of each point is stored
C     between calls. Points are identified by their order. SI units.
      subroutine vdload (
     1 nblock, ndim, stepTime, totalTime,
     2 amplitude, curCoords, velocity, dirCos,
     3 jltyp, sname, value )
      include 'vaba_param.inc'
      dimension curCoords(nblock,ndim), velocity(nblock,ndim),
     1 dirCos(nblock,ndim,ndim), value(nblock)
      character*80 sname
      dimension deepest(maxblk)
      save deepest
      data deepest /maxblk*0.d0/
      parameter ( strength = 1.2d9 )
      do k = 1, nblock
        z = curCoords(k,2)
        value(k) = 0.d0
        if (z .lt. 0.d0) then
          if (z .lt. deepest(k)) then
            value(k) = amplitude*strength
            deepest(k) = z
          else
            value(k) = amplitude*strength*0.01d0
          end if
        end if
      end do
      return
      end
