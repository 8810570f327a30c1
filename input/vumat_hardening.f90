! Isotropic elasticity with von Mises plasticity and linear hardening, by radial return.
!   props(1) Young's modulus     props(2) Poisson's ratio
!   props(3) yield stress        props(4) slope of the yield stress over plastic strain
!   state(1) equivalent plastic strain
subroutine vumat(nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal, &
    stepTime, totalTime, dt, cmname, coordMp, charLength, props, density, &
    strainInc, relSpinInc, tempOld, stretchOld, defgradOld, fieldOld, &
    stressOld, stateOld, enerInternOld, enerInelasOld, &
    tempNew, stretchNew, defgradNew, fieldNew, &
    stressNew, stateNew, enerInternNew, enerInelasNew)
  include 'vaba_param.inc'
  dimension props(nprops), density(nblock), coordMp(nblock,*), charLength(nblock), &
    strainInc(nblock,ndir+nshr), relSpinInc(nblock,nshr), tempOld(nblock), &
    stretchOld(nblock,ndir+nshr), defgradOld(nblock,ndir+nshr+nshr), &
    fieldOld(nblock,nfieldv), stressOld(nblock,ndir+nshr), stateOld(nblock,nstatev), &
    enerInternOld(nblock), enerInelasOld(nblock), tempNew(nblock), &
    stretchNew(nblock,ndir+nshr), defgradNew(nblock,ndir+nshr+nshr), fieldNew(nblock,nfieldv), &
    stressNew(nblock,ndir+nshr), stateNew(nblock,nstatev), enerInternNew(nblock), enerInelasNew(nblock)
  character*80 cmname
  dimension s(6)

  twog = props(1)/(1.d0 + props(2))
  bulk = props(1)/(3.d0*(1.d0 - 2.d0*props(2)))
  do k = 1, nblock
    trace = strainInc(k,1) + strainInc(k,2) + strainInc(k,3)
    pressure = (stressOld(k,1) + stressOld(k,2) + stressOld(k,3))/3.d0
    square = 0.d0
    do i = 1, ndir + nshr
      s(i) = stressOld(k,i) + twog*strainInc(k,i)
      if (i .le. ndir) then
        s(i) = s(i) - pressure - twog*trace/3.d0
        square = square + s(i)**2
      else
        square = square + 2.d0*s(i)**2
      end if
    end do
    trial = sqrt(1.5d0*square)
    flow = 0.d0
    factor = 1.d0
    ! At time zero the strains are fictitious, and the answer must be elastic.
    if (totalTime .gt. 0.d0) then
      excess = trial - (props(3) + props(4)*stateOld(k,1))
      if (excess .gt. 0.d0) then
        flow = excess/(1.5d0*twog + props(4))
        factor = (trial - 1.5d0*twog*flow)/trial
      end if
    end if
    pressure = pressure + bulk*trace
    work = 0.d0
    along = 0.d0
    do i = 1, ndir + nshr
      stressNew(k,i) = factor*s(i)
      if (i .le. ndir) stressNew(k,i) = stressNew(k,i) + pressure
      part = 0.5d0*(stressOld(k,i) + stressNew(k,i))
      if (i .gt. ndir) part = 2.d0*part
      work = work + part*strainInc(k,i)
      along = along + part*s(i)
    end do
    stateNew(k,1) = stateOld(k,1) + flow
    enerInternNew(k) = enerInternOld(k) + work/density(k)
    ! The plastic strain increment is 3/2 flow s/trial.
    enerInelasNew(k) = enerInelasOld(k)
    if (flow .gt. 0.d0) enerInelasNew(k) = enerInelasOld(k) + 1.5d0*flow*along/(trial*density(k))
  end do
end subroutine vumat
