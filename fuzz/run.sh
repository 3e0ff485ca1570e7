#!/usr/bin/env bash
# Runs fuzz targets in turn, and adds up what they did. See README.md.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
repository=$(dirname "$here")
work=${FUZZ_WORK:-$here/work}
target_folder=${CARGO_TARGET_DIR:-$here/target}
figures=$work/figures.tsv

usage() {
    echo "usage: fuzz/run.sh [--minutes N] [--rounds N] [--no-build] [TARGET...] | fuzz/run.sh --report" >&2
    exit 2
}

all_targets() {
    sed -n 's/^path = "targets\/\(.*\)\.rs"$/\1/p' "$here/Cargo.toml"
}

# The name of the dictionary of a target, and where its inputs come from beside its own folder of seeds.
dictionary_of() {
    case $1 in
        scene_*) echo scene ;;
        gltf | glb) echo gltf ;;
        texture | environment | picture) echo image ;;
        part | checkpoint) echo kept ;;
        *) echo "$1" ;;
    esac
}

endings_of() {
    case $1 in
        scene_ron) echo ron ;;
        scene_json) echo json ;;
        texture) echo png jpg hdr exr ;;
        environment) echo hdr exr ;;
        picture) echo png jpg hdr exr pfm ;;
        *) echo "$1" ;;
    esac
}

# The words of scene files are those of their schema.
scene_words() {
    grep -o '"[a-z][a-z_]*"' "$repository/scenes/scene.schema.json" | sort -u
}

# Collects small files with the right ending from the repository, and from the folders in FUZZ_DATA.
gather() {
    local target=$1 corpus=$2 ending found
    cp "$here/seeds/$target/"* "$corpus/" 2>/dev/null || true
    for ending in $(endings_of "$target"); do
        # shellcheck disable=SC2086 # a list of folders
        find "$repository/scenes" "$repository/tests/golden" ${FUZZ_DATA:-} -type f -iname "*.$ending" -size -20k |
            while read -r found; do
                cp "$found" "$corpus/seed-$(sha1sum <"$found" | cut -c1-16)"
            done
    done
}

# Runs one target for some seconds, and notes what it did.
run_target() {
    local target=$1 seconds=$2
    local corpus=$work/corpus/$target artifacts=$work/artifacts/$target log=$work/log/$target.log
    local dictionary=$here/dictionaries/$(dictionary_of "$target").dict
    mkdir -p "$corpus" "$artifacts" "$work/log" "$work/memory"
    [ -n "$(ls -A "$corpus")" ] || gather "$target" "$corpus"
    if [ ! -e "$dictionary" ]; then
        dictionary=$work/scene.dict
        scene_words >"$dictionary"
    fi
    local memory
    memory=$(mktemp -d "${FUZZ_MEMORY:-/dev/shm}/fuzz.XXXXXX")
    local before after outcome=0
    before=$(find "$artifacts" -type f | wc -l)
    # An image may have 2^28 pixels and take 1 GiB, even if it is all white and its file is short.
    local limits=(-rss_limit_mb=512 -malloc_limit_mb=256)
    case $target in texture | environment) limits=(-rss_limit_mb=3072 -malloc_limit_mb=1100) ;; esac
    TIMEFORMAT='cpu %U %S'
    {
        time TMPDIR=$memory ASAN_OPTIONS=quarantine_size_mb=8:detect_leaks=0 \
            "$target_folder/x86_64-unknown-linux-gnu/release/$target" "$corpus" \
            -max_total_time="$seconds" -max_len=20000 -dict="$dictionary" -artifact_prefix="$artifacts/" \
            "${limits[@]}" -timeout=60 -print_final_stats=1 -close_fd_mask=1 \
            >"$log" 2>&1 || outcome=$?
    } 2>"$log.cpu"
    rm -rf "$memory"
    after=$(find "$artifacts" -type f | wc -l)
    local executions coverage cpu
    executions=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log" | tail -1)
    [ -n "$executions" ] || executions=$(sed -n 's/^#\([0-9]*\).*/\1/p' "$log" | tail -1)
    coverage=$(sed -n 's/.* cov: \([0-9]*\) .*/\1/p' "$log" | tail -1)
    cpu=$(awk '/^cpu/ { print $2 + $3 }' "$log.cpu")
    printf '%s\t%s\t%s\t%s\t%s\t%s\n' "$(date -u +%FT%TZ)" "$target" "${executions:-0}" "${cpu:-0}" "${coverage:-0}" \
        $((after - before)) >>"$figures"
    [ "$outcome" = 0 ] || echo "$target ended with $outcome, see $log and $artifacts" >&2
}

report() {
    printf '%-14s %14s %10s %10s %10s\n' target executions 'CPU s' coverage findings
    awk -F'\t' '
        { runs[$2] += $3; cpu[$2] += $4; if ($5 > cov[$2]) cov[$2] = $5; bad[$2] += $6 }
        END {
            for (t in runs) {
                printf "%-14s %14d %10.0f %10d %10d\n", t, runs[t], cpu[t], cov[t], bad[t]
                a += runs[t]; b += cpu[t]; d += bad[t]
            }
            printf "%-14s %14d %10.0f %10s %10d\n", "~in all", a, b, "", d
        }' "$figures" | sort | tr -d '~'
}

minutes=1
rounds=1
build=yes
targets=()
while [ $# -gt 0 ]; do
    case $1 in
        --minutes) minutes=${2:-}; shift 2 || usage ;;
        --rounds) rounds=${2:-}; shift 2 || usage ;;
        --no-build) build=no; shift ;;
        --report) report; exit ;;
        -*) usage ;;
        *) targets+=("$1"); shift ;;
    esac
done
[ "${#targets[@]}" -gt 0 ] || mapfile -t targets < <(all_targets)
mkdir -p "$work"
if [ "$build" = yes ]; then
    (cd "$repository" && cargo +nightly fuzz build --fuzz-dir fuzz --target-dir "$target_folder")
fi
for ((round = 0; round < rounds; round++)); do
    for target in "${targets[@]}"; do
        run_target "$target" $((minutes * 60))
    done
done
report
