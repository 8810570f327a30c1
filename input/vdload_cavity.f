C     Resistance of dynamic cavity expansion on a fully embedded nose:
C     p = Y (A + C v_n**2 rho / Y) where the surface moves into the target, else 0
C     (constants of 6061-T6511 aluminium, SI units).
      subroutine vdload (
C Read only (unmodifiable) variables -
     1 nblock, ndim, stepTime, totalTime,
     2 amplitude, curCoords, velocity, dirCos,
     3 jltyp, sname,
C Write only (modifiable) variable -
     4 value )
C
      include 'vaba_param.inc'
C
      dimension curCoords(nblock,ndim), velocity(nblock,ndim),
     1 dirCos(nblock,ndim,ndim), value(nblock)
      character*80 sname
C
      parameter ( Y = 276.d6, rho = 2710.d0, A = 5.0394d0, C = 0.983d0 )
C
      do k = 1, nblock
        vn = velocity(k,1)*dirCos(k,1,1) + velocity(k,2)*dirCos(k,1,2)
        if (vn .gt. 0.d0) then
          value(k) = amplitude*(A*Y + C*rho*vn*vn)
        else
          value(k) = 0.d0
        end if
      end do
C
      return
      end
