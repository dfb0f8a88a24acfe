# A fresh machine needs python3 (3.11 or newer, with venv), git and make; everything else goes into .venv.

PYTHON ?= python3
PYTHONS ?= $(PYTHON)
BIN := .venv/bin
LOCKS := tools/requirements
PIP := $(BIN)/python $(LOCKS)/install.py

.PHONY: help setup sitl gcs test test-flights test-vcan test-pythons lint rooms bench bench-sweep fuzz kill load soak soak-vcan study study-safety study-adaptation paper wheels lock clean

help: ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-13s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

setup: .venv/.run .venv/.kernels ## install into .venv and compile the kernels

sitl: setup ## fly the demonstration mission and leave a report under runs/
	@$(BIN)/sternplane sitl $(ARGS)

gcs: setup ## fly in real time, and wait for a ground station; ARGS="--state DIR" keeps what it changes
	@echo "QGroundControl finds it; MAVProxy: --master=tcp:127.0.0.1:5760; MAVSDK: udpin://127.0.0.1:14540; Ctrl-C ends it"
	@trap ended=1 INT; $(BIN)/sternplane sitl --pace realtime --scenario station --gcs udpout:127.0.0.1:14550 \
		--gcs tcpin:127.0.0.1:5760 --gcs udpout:127.0.0.1:14540:generic $(ARGS) || [ $$? -eq 1 ] || [ -n "$$ended" ]

# Two at a time: the tests that fly in real time bear one neighbour. Both import all of it, and so do the processes that they
# start: bytecode is kept, whatever the environment asks for. File by file, for the sake of what a file shares; flights
# share none, and one file of them takes a quarter of the time.
PYTEST = $(BIN)/python -m pytest -n 2
test test-flights: export PYTHONDONTWRITEBYTECODE =
test: setup .venv/.dev ## run the tests
	@$(PYTEST) --dist loadfile --no-loadscope-reorder --ignore=tests/flights $(ARGS)

test-flights: setup .venv/.dev ## run those that fly whole missions with faults; they take eight minutes on two cores
	@$(PYTEST) --dist worksteal tests/flights $(ARGS)

test-vcan: setup .venv/.dev ## run the tests that need SocketCAN (root; says what is missing)
	@tests/vcan/run $(BIN)/python -m pytest -m vcan tests/vcan tests/contract/test_canopen_drives.py $(ARGS)

test-pythons: setup .venv/.dev ## install the wheel, fly and run the examples on each Python of PYTHONS="python3.11 python3.12 ..."
	@rm -rf build/wheel; $(BIN)/python -m pip --disable-pip-version-check wheel --quiet --no-deps --no-build-isolation \
		--wheel-dir build/wheel .
	@set -e; for python in $(PYTHONS); do $$python tests/package/on_python.py build/wheel/*.whl; done

lint: setup .venv/.dev ## style, types, import rules
	@$(BIN)/ruff check
	@$(BIN)/ruff format --check
	@$(BIN)/mypy
	@$(BIN)/lint-imports

rooms: setup .venv/.dev ## the folders, how many files and lines they have, and the layers of imports
	@$(BIN)/python -m sternplane.codegen.rooms

bench: setup .venv/.dev ## measure, and print JSON
	@$(BIN)/python -m sternplane.bench

bench-sweep: setup ## 1,000 flights of 60 s: flights/s, memory, and the same table after kills and over Dask; hours; ARGS="--n 60" for fewer
	@$(BIN)/python -m sternplane.bench.sweep $(ARGS)

fuzz: setup ## ten million odd packets into the ground links; ARGS="--packets 100000" for fewer, "--configurations 5000" for files, "--instruments 1000000" for devices
	@$(BIN)/python -m sternplane.fuzz $(ARGS)

kill: setup ## kill -9 at fifty random times, and judge the start after each by the truth; ARGS="--kills 5" for less
	@$(BIN)/python -m sternplane.kill $(ARGS)

load: setup ## what cycles cost, and how late they are: alone, with three busy stations, flooded; ARGS="--seconds 20" for less
	@$(BIN)/python -m sternplane.link_load $(ARGS)

soak: setup ## every io file in configs/ flies ten minutes in real time against a plant; ARGS="--seconds 60" for less, --at-sea, --fault
	@$(BIN)/python -m sternplane.soak $(ARGS)

soak-vcan: setup ## the same over the kernel's CAN (root), with real time as at sea
	@VCAN_TIMEOUT=$${VCAN_TIMEOUT:-9000} tests/vcan/run $(BIN)/python -m sternplane.soak --bus socketcan:vcan0 --at-sea $(ARGS)

study: setup ## the estimation study; ARGS=--short for its quick form
	@$(BIN)/sternplane study estimation $(ARGS)

study-adaptation: setup ## laws designed from what is learned; ARGS=--short for the quick form
	@$(BIN)/sternplane study adaptation $(ARGS)

study-safety: setup ## every fault, judged by the truth; ARGS=--short for the quick form, ARGS="--out DIR" to go on
	@$(BIN)/sternplane study safety $(ARGS)

paper: setup ## every experiment of the source paper
	@$(BIN)/sternplane paper $(ARGS)

wheels: .venv/.run ## a folder of wheels for a vehicle without internet; BOARD=aarch64 BOARD_PYTHON=3.11 for another computer
	@$(BIN)/python -m pip --disable-pip-version-check wheel --quiet --no-deps --no-build-isolation --wheel-dir wheels .
	@$(BIN)/python -m pip --disable-pip-version-check download --quiet --only-binary=:all: --require-hashes \
		-r $(LOCKS)/vehicle.txt --dest wheels $(if $(BOARD),--implementation cp --python-version $(BOARD_PYTHON) \
		$(foreach tag,2_28 2_27 2_17,--platform manylinux_$(tag)_$(BOARD)) --platform manylinux2014_$(BOARD))
	@cp $(LOCKS)/vehicle.txt wheels/requirements.txt
	@echo "wheels/: $$(ls wheels/*.whl | wc -l) wheels; copy the folder, see configs/vehicle.md"

lock: .venv/.dev ## pin the newest versions that pyproject.toml and the *.in files permit
	@cd $(LOCKS) && lock() { ../../$(BIN)/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes \
		--no-emit-index-url --no-header --excludes exclude.txt --extra report --extra i2c --extra data \
		../../pyproject.toml "$$@"; }; lock run.in -o run.txt; lock --extra cluster --extra gym dev.in -o dev.txt
	@cd $(LOCKS) && ../../$(BIN)/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes \
		--no-emit-index-url --no-header --extra i2c --constraints run.txt ../../pyproject.toml -o vehicle.txt

clean: ## remove what was installed, compiled and flown
	rm -rf .venv .cache build runs wheels *.egg-info

.venv/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "sternplane needs python 3.11 or newer; $$($(PYTHON) --version) was found: make PYTHON=python3.11" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || \
		{ echo "$(PYTHON) has no venv: apt-get install python3-venv" >&2; exit 1; }
	@new=; [ -e .venv ] || [ -L .venv ] || new=yes; $(PYTHON) -m venv .venv || \
		{ echo "sternplane: $(PYTHON) -m venv .venv has failed, as said above" >&2; [ -z "$$new" ] || rm -rf .venv; exit 1; }

.venv/.run: $(LOCKS)/run.txt pyproject.toml | .venv/bin/python
	@echo "installing into .venv"
	@$(PIP) $(LOCKS)/run.txt
	@$(BIN)/python -m pip --disable-pip-version-check install --quiet --no-deps --no-build-isolation --editable .
	@touch $@

.venv/.dev: $(LOCKS)/dev.txt .venv/.run
	@echo "installing what the tests need into .venv"
	@$(PIP) $(LOCKS)/dev.txt --no-deps
	@touch $@

.venv/.kernels: .venv/.run $(shell grep -rl '^@kernel' --include='*.py' firmware_py sim_bridge tools/sternplane)
	@$(BIN)/python -m sternplane.codegen.compile_kernels
	@touch $@
