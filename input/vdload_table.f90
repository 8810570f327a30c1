! Resistance from a table over depth: a target with graded strength.
! p = strength(depth) + factor v_n**2 where the surface moves into the target (at z < 0). SI units.
module resistance_table
  implicit none
  integer, parameter :: rows = 4
  real*8, parameter :: depths(rows) = (/ 0.d0, 0.01d0, 0.03d0, 0.2d0 /)
  real*8, parameter :: strengths(rows) = (/ 0.4d9, 1.2d9, 1.4d9, 1.4d9 /)
contains
  real*8 function strength(depth)
    real*8, intent(in) :: depth
    integer :: i
    strength = strengths(rows)
    do i = 2, rows
      if (depth < depths(i)) then
        strength = strengths(i-1) + (strengths(i) - strengths(i-1))*((depth - depths(i-1))/(depths(i) - depths(i-1)))
        exit
      end if
    end do
  end function
end module

subroutine vdload(nblock, ndim, stepTime, totalTime, amplitude, curCoords, velocity, dirCos, jltyp, sname, value)
  use resistance_table
  implicit none
  integer, intent(in) :: nblock, ndim, jltyp
  real*8, intent(in) :: stepTime, totalTime, amplitude
  real*8, intent(in) :: curCoords(nblock,ndim), velocity(nblock,ndim), dirCos(nblock,ndim,ndim)
  character(len=80), intent(in) :: sname
  real*8, intent(out) :: value(nblock)
  real*8, parameter :: factor = 0.983d0*2710.d0
  real*8 :: vn
  integer :: k
  do k = 1, nblock
    vn = velocity(k,1)*dirCos(k,1,1) + velocity(k,2)*dirCos(k,1,2)
    value(k) = 0.d0
    if (vn > 0.d0 .and. curCoords(k,2) < 0.d0) value(k) = amplitude*(strength(-curCoords(k,2)) + factor*vn*vn)
  end do
end subroutine
