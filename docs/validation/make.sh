#!/bin/sh
# Computes every number of docs/validation.md (see make.py): REVOLVE=path/to/revolve docs/validation/make.sh [--check] [--plot]
set -eu
cd "$(dirname "$0")/../.."
exec "${PYTHON:-python3}" docs/validation/make.py "$@"
