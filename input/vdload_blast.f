C     A blast wave that moves outward over a surface. After the front has reached
C     the radius r at time r/speed, the pressure decays (Friedlander's law):
C     p = peak (1 - t/duration) exp(-decay t/duration), t the time since arrival,
C     and is zero after the positive phase. SI units.
      subroutine vdload (
     1 nblock, ndim, stepTime, totalTime,
     2 amplitude, curCoords, velocity, dirCos,
     3 jltyp, sname, value )
      include 'vaba_param.inc'
      dimension curCoords(nblock,ndim), velocity(nblock,ndim),
     1 dirCos(nblock,ndim,ndim), value(nblock)
      character*80 sname
      parameter ( peak = 2.d6, speed = 800.d0, duration = 1.d-3,
     1 decay = 1.5d0 )
      do k = 1, nblock
        s = (totalTime - curCoords(k,1)/speed)/duration
        value(k) = 0.d0
        if (s .ge. 0.d0 .and. s .lt. 1.d0) then
          value(k) = amplitude*peak*(1.d0 - s)*exp(-decay*s)
        end if
      end do
      return
      end
