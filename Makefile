# Each target installs what is missing on Debian and Ubuntu (setup.sh) and says so; where nothing is missing, it
# changes nothing.

# On a terminal cargo's progress bar alone; elsewhere a line for each crate that it compiles.
build := if [ -t 2 ]; then export CARGO_TERM_PROGRESS_WHEN=always CARGO_TERM_PROGRESS_WIDTH=80 CARGO_TERM_QUIET=true; fi; \
	./setup.sh demo cargo build --release --locked

touchdown := target/release/touchdown

all_laws := pd,pd-reset,literal,proposed,impedance,ros2,fzi
tuned := experiment/tuned.toml
# eq. (2) at each sample has nothing to tune; on the elastic arm it swings up until a collision is latched.
tuned_laws := pd,pd-reset,proposed,impedance,ros2,fzi

# Default and tuned rows, by themselves: nothing calms a law that swings up.
alone := --gains default,tuned --set controller.oscillation.enabled=false
both := $(alone) --laws $(all_laws)

.PHONY: help demo report laws tune maps elastic free-motion keys test bits bench speed faults hostile fuzz audit memory soak doctor build install uninstall check format lint doc clean

help: ## list the targets (default)
	@sed -n 's/^\([a-z-]*\):.*## /\1\t/p' Makefile | expand -t 13

demo: ## the paper's experiment with both laws, as three processes over LCM: table, figure, data in target/demo
	@$(build)
	@$(touchdown) run elastic_arm --laws elastic,pd --record --out target/demo

report: ## laws, scenarios and maps as one HTML file: target/report/report.html
	@$(build)
	@$(touchdown) report

laws: ## every law on every robot over contact phases and seeds: docs/laws.txt
	@$(build)
	@{ $(touchdown) compare paper $(both) && $(touchdown) compare arm $(both) && \
	   $(touchdown) compare elastic $(both),elastic && \
	   $(touchdown) compare elastic_arm $(alone) --laws $(tuned_laws),elastic; } \
	   >target/laws.txt
	@mv target/laws.txt docs/laws.txt
	@cat docs/laws.txt

tune: ## tuned gains of every law on every robot: experiment/tuned.toml
	@$(build)
	@$(touchdown) tune paper --laws $(tuned_laws) --out $(tuned)
	@$(touchdown) tune arm --laws $(tuned_laws) --out $(tuned)
	@$(touchdown) tune elastic --laws $(tuned_laws),elastic --out $(tuned)
	@$(touchdown) tune elastic_arm --laws $(tuned_laws),elastic --out $(tuned)

maps: ## every law over contact, delay, robot, gears and period, thousands of runs: docs/map-*.svg, data in target/sweep
	@$(build)
	@$(touchdown) sweep shootout --out target/sweep/shootout
	@for map in target/sweep/shootout/*.svg; do cp $$map docs/map-$${map##*/}; done

elastic: ## the law elastic, a tuned pd and the lower bound under 28 conditions on elastic robots: docs/elastic.txt
	@$(build)
	@{ $(touchdown) bound paper && $(touchdown) bound arm && $(touchdown) bound elastic && \
	   $(touchdown) bound elastic_arm && $(touchdown) conditions elastic --set timing.seed=1001 && \
	   $(touchdown) conditions elastic_arm --set timing.seed=1001; } >target/elastic.txt
	@mv target/elastic.txt docs/elastic.txt
	@cat docs/elastic.txt

free-motion: ## what free motion leaves swinging, shaped and not, on every robot: docs/free-motion.txt
	@$(build)
	@{ $(touchdown) free-motion paper && $(touchdown) free-motion elastic && $(touchdown) free-motion arm && \
	   $(touchdown) free-motion elastic_arm; } \
	   >target/free-motion.txt
	@mv target/free-motion.txt docs/free-motion.txt
	@cat docs/free-motion.txt

keys: ## every key of a scenario with unit, limits and default: docs/configuration.md
	@./setup.sh demo cargo build --locked -p experiment --bin touchdown
	@target/debug/touchdown keys --markdown >target/configuration.md
	@mv target/configuration.md docs/configuration.md

test: ## all tests
	@./setup.sh test cargo test --workspace --locked

bits: ## the same bits in release and, emulated, on other CPUs
	@./setup.sh test cargo test --release --locked -p experiment --test golden
	@for cpu in Nehalem Haswell; do \
		CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUNNER="qemu-x86_64 -cpu $$cpu" \
		./setup.sh bits cargo test --locked -p experiment --test golden || exit 1; \
	done

# A Python of its own with a package that something is compared with.
python := target/python/bin/python
python_with = [ -e $(python) ] || ./setup.sh test python3 -m venv target/python; \
	$(python) -c "import $(1)" 2>/dev/null || $(python) -m pip install -q $(1)

bench: ## how fast a sweep and the network are on this machine (5 min), the network: docs/network.txt
	@$(build)
	@$(touchdown) sweep smoke --fresh --out target/sweep/bench
	@$(call python_with,lcm)
	@$(touchdown) bench network --python $(python) >target/network.txt
	@mv target/network.txt docs/network.txt
	@cat docs/network.txt

speed: ## cycles of all laws, simulation beside MuJoCo, sweeps, nodes, and how costs grow (7 min): docs/cycles.txt, speed.txt, growth-*.svg
	@$(build)
	@{ $(touchdown) bench controller paper && $(touchdown) bench controller elastic_arm; } >target/cycles.txt
	@mv target/cycles.txt docs/cycles.txt
	@$(call python_with,mujoco)
	@{ $(touchdown) bench simulation paper && $(touchdown) bench simulation elastic_arm && echo && \
	   $(touchdown) bench mujoco --python $(python) && echo && \
	   $(touchdown) bench nodes && echo && $(touchdown) bench growth --out docs; } >target/speed.txt
	@mv target/speed.txt docs/speed.txt
	@cat docs/cycles.txt docs/speed.txt

faults: ## what goes wrong in real time, when, and what comes of it (10 min): docs/faults.txt
	@./setup.sh test cargo build --workspace --bins --locked
	@target/debug/faults >target/faults.txt 2>target/faults.log; status=$$?; \
		mv target/faults.txt docs/faults.txt; cat docs/faults.txt; exit $$status

hostile: ## what an attacker who holds no key can do in real time, and what comes of it (10 min): docs/hostile.txt
	@./setup.sh test cargo build --workspace --bins --locked
	@target/debug/hostile >target/hostile.txt 2>target/hostile.log; status=$$?; \
		mv target/hostile.txt docs/hostile.txt; cat docs/hostile.txt; exit $$status

fuzz: ## libFuzzer on all that reads bytes from outside, 10^7 executions each (an hour on two cores): docs/fuzz.txt
	@./setup.sh fuzz fuzz/run.sh >target/fuzz.txt; status=$$?; mv target/fuzz.txt docs/fuzz.txt; cat docs/fuzz.txt; exit $$status

doctor: ## is this host fit for LCM over UDP multicast?
	@$(build)
	@$(touchdown) doctor

# Where `make install` puts things; below DESTDIR, which packages are built in. BUILT: where the programs are.
PREFIX ?= /usr/local
BUILT ?= target/release
programs := touchdown robot-sim sensor-sim controller
units := touchdown.service touchdown@.service
in_prefix := $(DESTDIR)$(PREFIX)
shared := $(in_prefix)/share/touchdown
documents := $(in_prefix)/share/doc/touchdown

build: ## the programs, for `make install`
	@$(build)

install: ## programs, units of systemd, scenarios, cells, message types, documents below PREFIX (/usr/local) and DESTDIR
	@for program in $(programs); do [ -x $(BUILT)/$$program ] || { echo "first, without root: make build" >&2; exit 1; }; done
	@install -d $(in_prefix)/bin $(in_prefix)/lib/systemd/system $(documents) \
		$(shared)/scenarios $(shared)/cells $(shared)/types $(shared)/examples
	@install -m 755 $(addprefix $(BUILT)/,$(programs)) $(in_prefix)/bin
	@for unit in $(units); do \
		sed 's#^ExecStart=/usr/local/#ExecStart=$(PREFIX)/#' docs/systemd/$$unit >$(in_prefix)/lib/systemd/system/$$unit && \
		chmod 644 $(in_prefix)/lib/systemd/system/$$unit || exit 1; \
	done
	@install -m 644 experiment/scenarios/*.toml $(shared)/scenarios
	@install -m 644 experiment/cells/*.toml $(shared)/cells
	@install -m 644 lcmtypes/types/*.lcm $(shared)/types
	@install -m 644 lcmtypes/examples/*.py $(shared)/examples
	@install -m 644 README.md LICENSE docs/lab.md docs/configuration.md $(documents)
	@install -m 644 lcmtypes/README.md $(documents)/messages.md

uninstall: ## what `make install` has put there; not /etc/touchdown, which is yours
	@rm -f $(addprefix $(in_prefix)/bin/,$(programs)) $(addprefix $(in_prefix)/lib/systemd/system/,$(units))
	@rm -rf $(shared) $(documents)

audit: ## licences, sources and second versions of what this is made of (cargo-deny, compiled on the first call)
	@cargo deny --version >/dev/null 2>&1 || ./setup.sh demo cargo install --locked --debug cargo-deny
	@cargo deny --locked check licenses bans sources
	@cargo deny --locked check advisories || echo "advisories: not checked, or not clean; see above" >&2

# AddressSanitizer comes first in a process, before what cargo links; valgrind looks for leaks.
asan = CARGO_TARGET_DIR=target/asan CFLAGS="-fsanitize=address -fno-omit-frame-pointer -g" \
	RUSTFLAGS="-Clink-arg=-Wl,--no-as-needed -Clink-arg=-lasan" ASAN_OPTIONS=detect_leaks=0 \
	CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUNNER="env LD_PRELOAD=$$(gcc -print-file-name=libasan.so)"

memory: ## the C below lcmtypes and what is unsafe there, under valgrind, then with AddressSanitizer (x86-64 Linux)
	@CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUNNER="valgrind --quiet --error-exitcode=1 --leak-check=full \
		--errors-for-leak-kinds=definite --suppressions=$(CURDIR)/lcmtypes/tests/valgrind.supp" \
		./setup.sh memory cargo test --locked -p lcmtypes --lib --test wire
	@$(asan) cargo test --locked --target x86_64-unknown-linux-gnu -p lcmtypes --lib --test wire

soak: ## 8 h simulated and 20 min in real time (half an hour in all): memory, open files and latency at begin and end: docs/soak.txt
	@./setup.sh test cargo build --workspace --bins --locked
	@target/debug/soak >target/soak.txt 2>target/soak.log; status=$$?; mv target/soak.txt docs/soak.txt; cat docs/soak.txt; \
		exit $$status

check: format lint doc ## what a change must pass besides the tests

format:
	@./setup.sh check cargo fmt --all --check

lint:
	@./setup.sh check cargo clippy --workspace --all-targets --locked -- -D warnings

doc:
	@RUSTDOCFLAGS="-D warnings" ./setup.sh check cargo doc --workspace --no-deps --locked

clean: ## remove what was built and recorded
	@rm -rf target
