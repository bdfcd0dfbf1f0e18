#!/bin/sh
# For a machine with a graphics card: does goblet work there, and how fast is it? Writes OUT/report.json and
# OUT/picture.png, in at most nine minutes after the build. The exit code is 1 if a part fails or runs out of time;
# the other parts run all the same. docs/gpu.md says what the parts are.
#
#   sh tests/gpu.sh [--device DEVICE] OUT [PART..]     all parts, unless some are named
#   sh tests/gpu.sh --dry-run OUT [PART..]             small sizes, on any device: does this script still work?
#   sh tests/gpu.sh --pack FOLDER                      lays all that is needed into a folder. There,
#                                                      `sh FOLDER/gpu.sh OUT` needs no source, no cargo and no network
set -eu
home=$(cd "$(dirname "$0")" && pwd)

say() {
    echo "gpu.sh: $*"
}

refuse() {
    say "$*" >&2
    exit 2
}

# ---- From the source to a folder that can be carried away

# Builds what runs. A dry run has the build of the other tests.
build() {
    say "building"
    set -- --release --test kernels --test physics --bench rays
    if [ "$dry_run" ]; then
        . tests/build.sh
        set -- --workspace --all-targets
    fi
    CARGO_TERM_COLOR=never cargo test --locked --no-run "$@" 2>"$scratch/build.log" || {
        cat "$scratch/build.log" >&2
        exit 1
    }
}

# The program that was built of a source.
built() {
    sed -n "s|^ *Executable $1 (\(.*\))\$|\1|p" "$scratch/build.log"
}

# Copies a program without what only a debugger reads, which is most of it.
copy_program() {
    strip -o "$2" "$1" 2>/dev/null || cp "$1" "$2"
}

# The first of the files that exists.
first_of() {
    for path; do
        if [ -f "$path" ]; then
            echo "$path"
            return
        fi
    done
}

manifest=explicit_layer.d/VkLayer_khronos_validation.json

# Vulkan's loader and validation layers, for a machine that has none.
copy_layers() {
    mkdir -p "$1"
    for name in libvulkan.so.1 libVkLayer_khronos_validation.so; do
        path=$(first_of /usr/lib/*-linux-gnu/$name /usr/lib/$name /usr/lib64/$name /usr/local/lib/$name)
        [ -z "$path" ] || cp -L "$path" "$1/$name"
    done
    path=$(first_of /usr/share/vulkan/$manifest /usr/local/share/vulkan/$manifest /etc/vulkan/$manifest)
    # A path with a slash is one beside the manifest.
    [ -z "$path" ] || sed 's|"library_path": "|&./|' "$path" >"$1/${manifest#*/}"
}

# Uses them, where there are no others.
find_layers() {
    [ -d "$home/lib" ] || return 0
    if [ -z "${VK_LAYER_PATH:-}" ] && [ -f "$home/lib/${manifest#*/}" ] &&
        [ -z "$(first_of /usr/share/vulkan/$manifest /usr/local/share/vulkan/$manifest /etc/vulkan/$manifest)" ]; then
        export VK_LAYER_PATH="$home/lib"
    fi
    if ! "$home/goblet" devices >/dev/null 2>&1; then
        export LD_LIBRARY_PATH="$home/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
    fi
}

# Lays what was built into a folder, with all that it reads.
lay() {
    mkdir -p "$1/scenes" "$1/tests"
    kernels=$(built tests/kernels/main.rs)
    copy_program "$kernels" "$1/kernels"
    copy_program "$(built tests/physics/main.rs)" "$1/physics"
    copy_program "$(built benches/rays.rs)" "$1/rays"
    copy_program "$(dirname "$kernels")/../goblet" "$1/goblet"
    cp tests/gpu.sh "$1/"
    cp scenes/*.pbrt "$1/scenes/"
    cp -r tests/reference "$1/tests/"
    # The tests have the bounds: "cornell-caustic 0.00330".
    sed -n 's/^ *assert_matches("\(.*\)", \([0-9.]*\), [0-9.]*);$/\1 \2/p' tests/physics/reference.rs >"$1/bounds"
    git describe --always --abbrev=9 --exclude='*' --dirty=+ >"$1/commit" 2>/dev/null || echo unknown >"$1/commit"
}

# ---- Running a part

# Runs a command in what its part has left of its time, and notes how it ends.
try() {
    left=$((end - $(date +%s)))
    code=124
    if [ "$left" -gt 0 ]; then
        code=0
        timeout -k 5 "$left" "$@" </dev/null || code=$?
    fi
    case $code in
        0) return 0 ;;
        # As `timeout` ends what it stops, and what does not stop.
        124 | 137) if [ "$status" = ok ]; then status="out of time"; fi ;;
        *) status=failed ;;
    esac
    echo "exit code $code: $*" >&2
    return 1
}

# The same for a program that takes --device.
try_on_device() {
    if [ "$device" ]; then set -- "$@" --device "$device"; fi
    try "$@"
}

render() {
    try_on_device "$home/goblet" render --quiet "$@"
}

# Runs tests of a suite with or without validation layers, `on` or `off`, and counts them. No test is no success.
suite() {
    name=$1
    layers=$2
    shift 2
    try env GOBLET_TEST_LAYERS="$layers" "$home/$name" "$@" >"$folder/$name.txt" || :
    tests=$(sed -n 's/^running \([0-9]*\) tests*$/\1/p' "$folder/$name.txt")
    passed=$(grep -c ' \.\.\. ok$' "$folder/$name.txt") || :
    echo "{ \"tests\": ${tests:-0}, \"passed\": $passed }" >"$folder/$name.json"
    grep -v ' \.\.\. ok$' "$folder/$name.txt"
    [ "$passed" -gt 0 ]
}

# ---- The parts. Each leaves JSON files in $folder; what it prints is its log.

part_devices() {
    try "$home/goblet" devices
}

# Without the layers, which a machine may lack and which change times.
part_kernels() {
    # shellcheck disable=SC2086 # a list of names
    suite kernels off $kernel_tests
}

part_references() {
    while read -r name bound; do
        case " ${reference_names:-$name} " in *" $name "*) ;; *) continue ;; esac
        # The squared error falls with the iterations, at most as fast as they grow.
        bound=$(awk "BEGIN { print $bound * 64 / $reference_iterations }")
        image=$folder/$name.exr
        render "$references/$name.pbrt" --iterations "$reference_iterations" -o "$image" || continue
        try "$home/goblet" compare "$image" "$references/$name.exr" --json \
            --max-relmse "$bound" --max-energy 0.015 >"$folder/$name.json" || :
    done <"$home/bounds"
    set -- "$folder"/*.json
    [ -f "$1" ]
}

# Images that must be the same, byte for byte.
part_bytes() {
    different=0
    for name in $byte_scenes; do
        expected=$folder/$name.exr
        set -- "$references/$name.pbrt" --resolution "$byte_size" --photons "$byte_photons"
        render "$@" --iterations 4 -o "$expected" || continue
        render "$@" --iterations 2 --checkpoint "$folder/half" -o "$folder/half.exr" || continue
        results=
        for change in "--workgroup-size 32" "--workgroup-size 64" "--workgroup-size 128" \
            "--batch-size 777" "--batch-size 65536" "--lookup kd-tree" "--resume $folder/half"; do
            # shellcheck disable=SC2086 # an option and its value
            render "$@" --iterations 4 $change -o "$folder/other.exr" || continue
            same=true
            cmp "$expected" "$folder/other.exr" || { same=false && different=$((different + 1)); }
            results="$results${results:+, }\"${change%" $folder/half"}\": $same"
        done
        echo "{ $results }" >"$folder/$name.json"
    done
    [ "$different" -eq 0 ]
}

# The other tests of physics take more time, or are the part before.
part_validation() {
    # shellcheck disable=SC2086 # lists of names
    suite kernels on $validated_kernel_tests || return 1
    # shellcheck disable=SC2086
    suite physics on $validated_physics_tests --skip reference:: --skip convergence:: --skip error_estimate::
}

part_speed() {
    for scene in "$home"/scenes/*.pbrt; do
        name=$(basename "$scene" .pbrt)
        for size in $speed_sizes; do
            # Pixels, photons.
            render "$scene" --resolution "${size%:*}" --photons "${size#*:}" --iterations "$speed_iterations" --time 3 \
                -o "$folder/speed.exr" --stats "$folder/$name-${size%:*}.json" || :
        done
    done
}

part_rays() {
    # shellcheck disable=SC2086 # options
    try_on_device "$home/rays" $ray_options >"$folder/rays.txt" || return 1
    lines <"$folder/rays.txt" | { echo "[" && cat && echo "]"; } >"$folder/rays.json"
}

# The homework's picture. If there is no time for all photons, it is of those that there are.
part_picture() {
    # shellcheck disable=SC2086 # options
    render "$home/scenes/wine-cup.pbrt" --integrator ppm --eye-paths 1 --radius .005 $picture_options \
        --time $(($(limit_of picture) - 25)) -o "$out/picture.png" --stats "$folder/picture.json" || return 1
    photons=$(sed -n 's/^ *"photons": \([0-9]*\),$/\1/p' "$folder/picture.json")
    echo "${photons:-0} of $picture_photons photons"
    [ "${photons:-0}" -ge "$picture_photons" ] || status="out of time"
    [ -s "$out/picture.png" ]
}

# Seconds that a part may take. With five more for each, should it have to be killed, they are nine minutes.
limit_of() {
    case $1 in
        devices) echo 5 ;;
        kernels) echo 40 ;;
        references) echo 60 ;;
        bytes) echo 45 ;;
        validation) echo 90 ;;
        speed) echo 75 ;;
        rays) echo 45 ;;
        picture) echo 140 ;;
        *) return 1 ;;
    esac
}
all_parts="devices kernels references bytes validation speed rays picture"

full_sizes() {
    kernel_tests=
    reference_names=
    reference_iterations=64
    byte_scenes="cornell-caustic shapes"
    byte_size=256x256
    byte_photons=300000
    validated_kernel_tests=
    validated_physics_tests=
    speed_sizes="512x512:262144 1024x1024:1048576"
    speed_iterations=64
    ray_options=
    picture_photons=4000000000
    # Rounds are of whole iterations, so that they have a little more than is asked for.
    picture_options="--resolution 2400x1800 --photons 2097152 --photons-per-round 5e8 --rounds 8"
}

small_sizes() {
    kernel_tests="subgroup:: sum:: circle::"
    reference_names="cornell-caustic revolution"
    reference_iterations=4
    byte_scenes=cornell-caustic
    byte_size=48x48
    byte_photons=20000
    validated_kernel_tests="subgroup:: sum::"
    validated_physics_tests="metamorphic::the_size_of_workgroups"
    speed_sizes="32x24:4096"
    speed_iterations=2
    ray_options="--rays 4096 --turns 1 --only water-1e3"
    picture_photons=32768
    picture_options="--resolution 64x48 --photons 4096 --photons-per-round 16384 --rounds 2"
}

# ---- The report

# Text as strings of JSON, one a line.
lines() {
    tr '\t' ' ' | tr -d '\000-\010\013-\037' | sed 's/[\\"]/\\&/g; s/.*/"&"/; $!s/$/,/'
}

# What there is of a part: its JSON files as they are, and its log.
report_part() {
    folder=$scratch/$1
    printf '"%s": ' "$1"
    if [ ! -f "$folder/ended" ]; then
        printf '{"status": "not run"}'
        return
    fi
    printf '{%s, "limit": %s, "results": {' "$(cat "$folder/ended")" "$(limit_of "$1")"
    between=
    for file in "$folder"/*.json; do
        [ -s "$file" ] || continue
        printf '%s\n"%s": ' "$between" "$(basename "$file" .json)"
        cat "$file"
        between=,
    done
    printf '}, "log": [\n'
    tail -n 400 "$folder/log" | lines
    printf ']}'
}

# All parts, in the state that they are in.
report() {
    {
        printf '{\n"goblet": %s,\n' "$("$home/goblet" --version | lines)"
        printf '"commit": %s,\n"system": %s,\n' "$(lines <"$home/commit")" "$(uname -srm | lines)"
        printf '"date": "%s",\n"dry_run": %s,\n' "$date" "${dry_run:-false}"
        printf '"seconds": %s,\n"parts": {' "$(($(date +%s) - start))"
        between=
        for each in $parts; do
            printf '%s\n' "$between"
            report_part "$each"
            between=,
        done
        printf '\n}\n}\n'
    } >"$scratch/report.json"
    cp "$scratch/report.json" "$out/report.json"
}

# Runs a part, and notes in `ended` how that went.
run_part() {
    folder=$scratch/$1
    mkdir "$folder"
    begin=$(date +%s)
    end=$((begin + $(limit_of "$1")))
    status=ok
    "part_$1" >"$folder/log" 2>&1 || if [ "$status" = ok ]; then status=failed; fi
    seconds=$(($(date +%s) - begin))
    printf '"status": "%s", "seconds": %s' "$status" "$seconds" >"$folder/ended"
    say "$1: $status, $seconds seconds"
}

# ---- What is asked for

dry_run=
device=
pack=
parse() {
    usage="expected [--device DEVICE] [--dry-run] OUT [PART..], or --pack FOLDER"
    while [ $# -gt 0 ]; do
        case $1 in
            --dry-run) dry_run=true ;;
            --device | --pack)
                [ $# -gt 1 ] || refuse "$1 needs a value; $usage"
                if [ "$1" = --pack ]; then pack=$2; else device=$2; fi
                shift
                ;;
            -*) refuse "unknown option $1; $usage" ;;
            *) break ;;
        esac
        shift
    done
    if [ "$pack" ]; then return; fi
    [ $# -gt 0 ] || refuse "$usage"
    out=$1
    shift
    parts=${*:-$all_parts}
    for part in $parts; do
        limit_of "$part" >/dev/null || refuse "there is no part $part; there are $all_parts"
    done
}

# Runs the parts, from the folder that `lay` has made.
run_parts() {
    # What goblet takes on its own is the first device that fits.
    "$home/goblet" devices >"$scratch/devices.txt" 2>&1 || refuse "$(cat "$scratch/devices.txt")"
    kind=$(sed -n 's/^   \(.*\); driver .*; fits$/\1/p' "$scratch/devices.txt" | head -n 1)
    if [ "$kind" = CPU ] && [ ! "$dry_run$device" ]; then
        refuse "the only device that can render is a CPU; --dry-run tries this script on it, --device runs it in full"
    fi
    if [ "$dry_run" ]; then small_sizes; else full_sizes; fi
    references=$home/tests/reference
    # Where the tests look; cargo says it in the same words.
    export CARGO_MANIFEST_DIR="$home" CARGO_BIN_EXE_goblet="$home/goblet"
    export GOBLET_TEST_DEVICE="$device" GOBLET_CACHE="$scratch/cache"

    mkdir -p "$out"
    rm -f "$out/report.json" "$out/picture.png"
    start=$(date +%s)
    date=$(date -u +%Y-%m-%dT%H:%M:%SZ)
    for part in $parts; do
        run_part "$part"
        # After each part: who stops this keeps what there is.
        report
    done
    say "$out/report.json has what was found"
    # The report says whether all is well.
    for part in $parts; do
        grep -q "^\"$part\": {\"status\": \"ok\", " "$out/report.json" || exit 1
    done
}

parse "$@"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
trap 'exit 130' INT TERM
if [ -f "$home/goblet" ]; then
    [ ! "$pack" ] || refuse "only the script in the source can pack"
    find_layers
    run_parts
elif [ "$pack" ]; then
    mkdir -p "$pack"
    pack=$(cd "$pack" && pwd)
    cd "$home/.."
    build
    lay "$pack"
    copy_layers "$pack/lib"
    say "$pack has $(du -sh "$pack" | cut -f 1)"
else
    (cd "$home/.." && build && lay "$scratch/pack")
    sh "$scratch/pack/gpu.sh" "$@"
fi
