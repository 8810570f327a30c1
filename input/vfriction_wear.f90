! Friction whose coefficient falls linearly with the slip so far, as a surface is polished.
! props(1): coefficient at the start; props(2): slip at which it vanishes; state(1): slip so far.
      subroutine vfriction(fTangential, state, nBlock, nBlockAnal, nBlockEdge, nNodState, nNodSlv, nNodMst, &
          nFricDir, nDir, nStates, nProps, nTemp, nFields, jFlags, rData, surfInt, surfSlv, surfMst, jConSlvUid, &
          jConMstUid, props, dSlipFric, fStickForce, fTangPrev, fNormal, areaCont, dircosN, dircosSl, shapeSlv, &
          shapeMst, coordSlv, coordMst, velSlv, velMst, tempSlv, tempMst, fieldSlv, fieldMst)
      include 'vaba_param.inc'
      character*80 surfInt, surfSlv, surfMst
      dimension fTangential(nFricDir,nBlock), state(nStates,nNodState,nBlock), jFlags(3), rData(4), &
          jConSlvUid(nNodSlv,nBlock), jConMstUid(nNodMst,nBlockAnal), props(nProps), dSlipFric(nDir,nBlock), &
          fStickForce(nBlock), fTangPrev(nDir,nBlock), fNormal(nBlock), areaCont(nBlock), dircosN(nDir,nBlock), &
          dircosSl(nDir,nBlock), shapeSlv(nNodSlv,nBlockEdge), shapeMst(nNodMst,nBlockAnal), &
          coordSlv(nDir,nNodSlv,nBlock), coordMst(nDir,nNodMst,nBlockAnal), velSlv(nDir,nNodSlv,nBlock), &
          velMst(nDir,nNodMst,nBlockAnal), tempSlv(nBlock), tempMst(nBlockAnal), fieldSlv(nFields,nBlock), &
          fieldMst(nFields,nBlockAnal)
      do k = 1, nBlock
! law
        coefficient = props(1)*max(0.d0, 1.d0 - state(1,1,k)/props(2))
        force = min(coefficient*fNormal(k), fStickForce(k))
        fTangential(1,k) = -force
        if (force .lt. fStickForce(k)) state(1,1,k) = state(1,1,k) + dSlipFric(1,k)
      end do
      end
