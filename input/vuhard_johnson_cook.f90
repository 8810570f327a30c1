! Johnson and Cook's yield stress as a VUHARD: A, B, n, C, m, reference rate, transition and melting temperature.
! *PLASTIC, HARDENING=USER, PROPERTIES=8
subroutine vuhard(nblock, jElem, kIntPt, kLayer, kSecPt, lAnneal, stepTime, totalTime, dt, cmname, nstatev, nfieldv, nprops, &
    props, tempOld, tempNew, fieldOld, fieldNew, stateOld, eqps, eqpsRate, yield, dyieldDtemp, dyieldDeqps, stateNew)
  include 'vaba_param.inc'
  character*80 cmname
  dimension jElem(nblock), props(nprops), tempOld(nblock), tempNew(nblock), fieldOld(nblock,nfieldv), &
    fieldNew(nblock,nfieldv), stateOld(nblock,nstatev), eqps(nblock), eqpsRate(nblock), yield(nblock), &
    dyieldDtemp(nblock), dyieldDeqps(nblock,2), stateNew(nblock,nstatev)

  do k = 1, nblock
    hardened = props(1)
    slope = 0.d0
    if (eqps(k) > 0.d0) then
      hardened = props(1) + props(2)*eqps(k)**props(3)
      slope = props(2)*props(3)*eqps(k)**(props(3) - 1.d0)
    end if
    rated = 1.d0
    byRate = 0.d0
    if (eqpsRate(k) > props(6)) then
      rated = 1.d0 + props(4)*log(eqpsRate(k)/props(6))
      byRate = props(4)/eqpsRate(k)
    end if
    theta = max((tempNew(k) - props(7))/(props(8) - props(7)), 0.d0)
    softened = 1.d0 - theta**props(5)
    byHeat = 0.d0
    if (theta > 0.d0) byHeat = -props(5)*theta**(props(5) - 1.d0)/(props(8) - props(7))
    yield(k) = hardened*rated*softened
    dyieldDeqps(k,1) = slope*rated*softened
    dyieldDeqps(k,2) = hardened*byRate*softened
    dyieldDtemp(k) = hardened*rated*byHeat
  end do
end subroutine
