! Constitutive laws in the forms of the manuals: total laws of the stretch or of the deformation gradient, and rate forms,
! in the axes that rotate with the material. Components: rr, zz, hoop, rz.
!   props(1) number of the law       props(2) shear modulus      props(3) bulk modulus
!   props(4) to props(6) constants of the law
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
  dimension u(4), b(4), e(4), s(4), old(4), new(4), st(nstatev)
  real*8 new, mu, kbulk

  mu = props(2)
  kbulk = props(3)
  do k = 1, nblock
    u = stretchNew(k,1:4)
    e = strainInc(k,1:4)
    old = stressOld(k,1:4)
    st = stateOld(k,:)
    xj = (u(1)*u(2) - u(4)**2)*u(3)
    b = square(u)
    select case (nint(props(1)))
    case (1)   ! neo-Hooke, from the stretch
      new = mu/xj*deviator(b*xj**(-2.d0/3.d0)) + sphere(kbulk*(xj - 1.d0))
    case (2)   ! neo-Hooke, from R^T F
      b = square(corotated(defgradNew(k,1:5)))
      new = mu/xj*deviator(b*xj**(-2.d0/3.d0)) + sphere(kbulk*(xj - 1.d0))
    case (3)   ! Mooney-Rivlin, C10 = 4 C01
      b = b*xj**(-2.d0/3.d0)
      new = mu/xj*deviator((0.8d0 + 0.2d0*sum(b(1:3)))*b - 0.2d0*square(b)) + sphere(kbulk*(xj - 1.d0))
    case (4)   ! Ogden, one term, from principal stretches
      centre = 0.5d0*(u(1) + u(2))
      radius = sqrt(0.25d0*(u(1) - u(2))**2 + u(4)**2)
      s(1:3) = (/ centre + radius, centre - radius, u(3) /)
      s(1:3) = (s(1:3)*xj**(-1.d0/3.d0))**props(4)
      s(1:3) = 2.d0*mu/(props(4)*xj)*(s(1:3) - sum(s(1:3))/3.d0) + kbulk*(xj - 1.d0)
      c2 = 1.d0
      s2 = 0.d0
      if (radius .gt. 0.d0) then
        c2 = 0.5d0*(u(1) - u(2))/radius
        s2 = u(4)/radius
      end if
      new(1) = 0.5d0*(s(1) + s(2)) + 0.5d0*(s(1) - s(2))*c2
      new(2) = 0.5d0*(s(1) + s(2)) - 0.5d0*(s(1) - s(2))*c2
      new(3) = s(3)
      new(4) = 0.5d0*(s(1) - s(2))*s2
    case (5)   ! Fung, orthotropic skin: second Piola-Kirchhoff stress from the Green strain
      e = 0.5d0*(b - sphere(1.d0))
      q = props(4)*e(1)**2 + props(5)*(e(2)**2 + e(3)**2) + 2.d0*props(6)*e(1)*e(2) + props(6)*e(4)**2
      s = mu*exp(q)*(/ props(4)*e(1) + props(6)*e(2), props(5)*e(2) + props(6)*e(1), props(5)*e(3), &
        0.5d0*props(6)*e(4) /)
      new = between(u, s)/xj + sphere(kbulk*(xj - 1.d0))
    case (6)   ! neo-Hooke with fibres along the angle props(4)
      x = u(1)*cos(props(4)) + u(4)*sin(props(4))
      y = u(4)*cos(props(4)) + u(2)*sin(props(4))
      fibre = 2.d0*props(5)*(x*x + y*y - 1.d0)/xj
      new = mu/xj*deviator(b*xj**(-2.d0/3.d0)) + sphere(kbulk*(xj - 1.d0)) &
        + fibre*(/ x*x, y*y, 0.d0, x*y /)
    case (7)   ! St Venant-Kirchhoff
      e = 0.5d0*(b - sphere(1.d0))
      new = between(u, sphere((kbulk - 2.d0/3.d0*mu)*sum(e(1:3))) + 2.d0*mu*e)/xj
    case (8)   ! hypoelastic
      new = trial(old, e)
    case (9)   ! von Mises plasticity, linear isotropic hardening
      new = trial(old, e)
      excess = mises(new) - props(4) - props(5)*st(1)
      if (excess .gt. 0.d0) then
        dp = excess/(3.d0*mu + props(5))
        new = new - 3.d0*mu*dp/mises(new)*deviator(new)
        st(1) = st(1) + dp
      end if
    case (10)  ! von Mises plasticity, linear kinematic hardening; back stress in the state variables 2 to 5
      new = trial(old, e)
      s = deviator(new) - st(2:5)
      excess = mises(s) - props(4)
      if (excess .gt. 0.d0) then
        dp = excess/(3.d0*mu + props(5))
        new = new - 3.d0*mu*dp/mises(s)*s
        st(2:5) = st(2:5) + props(5)*dp/mises(s)*s
        st(1) = st(1) + dp
      end if
    case (11)  ! viscoelastic solid; stress of the Maxwell element in the state variables 2 to 5
      s = exp(-dt/props(4))*st(2:5) + 2.d0*props(5)*exp(-0.5d0*dt/props(4))*deviator(e)
      new = trial(old, e) + s - st(2:5)
      st(2:5) = s
    case (12)  ! Drucker-Prager without dilation
      new = trial(old, e)
      q = mises(new)
      excess = q - props(4) + props(5)*sum(new(1:3))/3.d0
      if (excess .gt. 0.d0) then
        dp = min(excess, q)/(3.d0*mu)
        new = new - 3.d0*mu*dp/q*deviator(new)
        st(1) = st(1) + dp
      end if
    case (13)  ! damage; accumulated strain in the state variables 2 to 5
      st(2:5) = st(2:5) + e
      strain = 2.d0/3.d0*mises(deviator(st(2:5)))
      st(1) = max(st(1), strain - props(4))
      new = exp(-st(1)/props(5))*trial(0.d0*e, st(2:5))
    end select
    stressNew(k,1:4) = new
    stateNew(k,:) = st
  end do

contains

  function sphere(value)
    dimension sphere(4)
    sphere = (/ value, value, value, 0.d0 /)
  end function

  function deviator(t)
    dimension deviator(4), t(4)
    deviator = t - sphere((t(1) + t(2) + t(3))/3.d0)
  end function

  function mises(t)
    real*8 mises
    dimension t(4), d(4)
    d = deviator(t)
    mises = sqrt(1.5d0*(d(1)**2 + d(2)**2 + d(3)**2 + 2.d0*d(4)**2))
  end function

  function square(t)
    dimension square(4), t(4)
    square = (/ t(1)**2 + t(4)**2, t(2)**2 + t(4)**2, t(3)**2, t(4)*(t(1) + t(2)) /)
  end function

  ! U S U
  function between(t, s)
    dimension between(4), t(4), s(4)
    a11 = t(1)*s(1) + t(4)*s(4)
    a12 = t(1)*s(4) + t(4)*s(2)
    a21 = t(4)*s(1) + t(2)*s(4)
    a22 = t(4)*s(4) + t(2)*s(2)
    between = (/ a11*t(1) + a12*t(4), a21*t(4) + a22*t(2), t(3)**2*s(3), a11*t(4) + a12*t(2) /)
  end function

  ! R^T F of a deformation gradient rr, zz, hoop, rz, zr
  function corotated(f)
    dimension corotated(4), f(5)
    angle = atan2(f(5) - f(4), f(1) + f(2))
    ca = cos(angle)
    sa = sin(angle)
    corotated = (/ ca*f(1) + sa*f(5), ca*f(2) - sa*f(4), f(3), ca*f(4) + sa*f(2) /)
  end function

  function trial(t, e)
    dimension trial(4), t(4), e(4)
    trial = t + 2.d0*mu*deviator(e) + sphere(kbulk*(e(1) + e(2) + e(3)))
  end function
end subroutine
