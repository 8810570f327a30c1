! Strain energy of Holzapfel, Gasser and Ogden for any number of families of fibres.
!   props(1) C10, half the shear modulus of the matrix     props(2) D, two over the bulk modulus
!   props(3) stiffness k1 of the fibres     props(4) exponent k2     props(5) dispersion kappa, 0 to 1/3
subroutine vuanisohyper_inv(nblock, nFiber, nInv, jElem, kIntPt, kLayer, kSecPt, cmname, &
    nstatev, nfieldv, nprops, props, tempOld, tempNew, fieldOld, fieldNew, stateOld, &
    sInvariant, zeta, uDev, duDi, d2uDiDi, stateNew)
  include 'vaba_param.inc'
  dimension jElem(nblock), props(nprops), tempOld(nblock), tempNew(nblock), &
    fieldOld(nblock,nfieldv), fieldNew(nblock,nfieldv), stateOld(nblock,nstatev), &
    sInvariant(nblock,nInv), zeta(nblock,nFiber*(nFiber-1)/2), uDev(nblock), &
    duDi(nblock,nInv), d2uDiDi(nblock,nInv*(nInv+1)/2), stateNew(nblock,nstatev)
  character*80 cmname

  do k = 1, nblock
    uDev(k) = props(1)*(sInvariant(k,1) - 3.d0)
    duDi(k,1) = props(1)
    volume = sInvariant(k,3)
    duDi(k,3) = (volume - 1.d0/volume)/props(2)
    d2uDiDi(k,6) = (1.d0 + 1.d0/volume**2)/props(2)
    do i = 1, nFiber
      ! Place of the fourth invariant of family i, and of the second derivatives by it.
      n4 = 4 + i*(i - 1) + 2*(i - 1)
      n14 = 1 + n4*(n4 - 1)/2
      n44 = n4 + n4*(n4 - 1)/2
      strain = props(5)*(sInvariant(k,1) - 3.d0) + (1.d0 - 3.d0*props(5))*(sInvariant(k,n4) - 1.d0)
      if (strain .ge. 0.d0) then
        growth = exp(props(4)*strain**2)
        slope = props(3)*strain*growth
        curve = props(3)*(1.d0 + 2.d0*props(4)*strain**2)*growth
        uDev(k) = uDev(k) + props(3)/(2.d0*props(4))*(growth - 1.d0)
        duDi(k,1) = duDi(k,1) + props(5)*slope
        duDi(k,n4) = (1.d0 - 3.d0*props(5))*slope
        d2uDiDi(k,1) = d2uDiDi(k,1) + props(5)**2*curve
        d2uDiDi(k,n14) = props(5)*(1.d0 - 3.d0*props(5))*curve
        d2uDiDi(k,n44) = (1.d0 - 3.d0*props(5))**2*curve
      end if
    end do
  end do
end subroutine
