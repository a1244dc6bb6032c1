#!/bin/sh
# Fuzzes with libFuzzer, each target for so many executions, or those that are named:
#
#     fuzz/run.sh [EXECUTIONS [TARGET...]]
#
# Needs only the stable compiler: the options below are what `cargo fuzz --sanitizer none` gives it, and a C++ compiler. What is
# found beyond fuzz/corpus is kept in target/fuzz/corpus, what ends the program in target/fuzz.
set -eu
cd "$(dirname "$0")"
runs=${1:-10000000}
[ $# = 0 ] || shift
[ $# != 0 ] || set -- $(sed -n 's/^    ("\(.*\)", .*),$/\1/p' targets.rs)
export CARGO_TARGET_DIR=$PWD/../target/fuzz/build
RUSTFLAGS="--cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
-Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
-Cllvm-args=-sanitizer-coverage-trace-compares" \
    cargo build --release --locked --target "$(rustc -vV | sed -n 's/^host: //p')"
fuzz=$(ls "$CARGO_TARGET_DIR"/*/release/fuzz)
export fuzz runs
# One target: what is said of it goes to a file, so that several cores can be at work.
fuzz_one=$(cat <<'END'
    target=$1
    mkdir -p ../target/fuzz/corpus/"$target" corpus/"$target"
    FUZZ_TARGET=$target "$fuzz" -runs="$runs" -artifact_prefix=../target/fuzz/"$target"- -print_final_stats=1 -seed=12 \
        -timeout=10 -rss_limit_mb=2048 ../target/fuzz/corpus/"$target" corpus/"$target" \
        >../target/fuzz/"$target".log 2>&1 && said="survived" || said="FAILED: target/fuzz/$target.log"
    executed=$(sed -n 's/^stat::number_of_executed_units: //p' ../target/fuzz/"$target".log)
    rate=$(sed -n 's/^stat::average_exec_per_sec: *//p' ../target/fuzz/"$target".log)
    covered=$(sed -n 's/.* cov: \([0-9]*\) .*/\1/p' ../target/fuzz/"$target".log | tail -n 1)
    printf '%-10s %11s executions, %7s a second, %6s edges: %s\n' "$target" "$executed" "$rate" "$covered" "$said" \
        >../target/fuzz/"$target".said
    [ "$said" = survived ]
END
)
printf '%s\n' "$@" | xargs -P "$(nproc)" -I '{}' sh -euc "$fuzz_one" fuzz_one '{}' && failed="" || failed=yes
echo "\
libFuzzer on everything that reads bytes from outside (\`make fuzz\`, fuzz/targets.rs), with overflow checks and debug assertions;
without AddressSanitizer: the code below is C in \`message\` alone, over which valgrind and AddressSanitizer watch in
\`make memory\`. edges: of the whole program.
"
for target; do
    cat ../target/fuzz/"$target".said
done
[ -z "$failed" ]
