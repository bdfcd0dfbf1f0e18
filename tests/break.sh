#!/bin/sh
# Breaks the estimator in one way at a time, and lists the tests that notice. Fails if a break
# survives, or if the line that it changes is no longer there.
#
#   sh tests/break.sh [NUMBER...]     all breaks, unless numbers are given
#   sh tests/break.sh check           only finds the lines, as tests/run.sh does
#
# Works in a copy of the committed and changed files under target/break, and takes about a minute
# and a half a break on two cores.
set -eu
cd "$(dirname "$0")/.."
root=$PWD
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$root/target}"
copy=$CARGO_TARGET_DIR/break
# What is built for one run of the tests is not worth optimising.
export CARGO_INCREMENTAL=0 CARGO_PROFILE_DEV_OPT_LEVEL=0 CARGO_PROFILE_DEV_DEBUG=false

# Closed forms and kernels: the tests that take longest find nothing that these do not.
quick() {
    cargo test --locked --quiet --test kernels --test physics -- --skip survey --skip reference \
        --skip convergence --skip error_estimate --skip metamorphic --skip extremes --skip revolution
}

# One break a line: name | text in the shaders | what replaces it.
breaks() {
    cat <<'LIST'
next-event estimation drops the cosine at the surface|direct.radiance * (cos_surface * weight / direct.pdf)|direct.radiance * (weight / direct.pdf)
flux of photons counts double|visible_throughputs_at(pixel).rgb * flux * (flux_scale / radius2)|visible_throughputs_at(pixel).rgb * flux * (2.0 * flux_scale / radius2)
photons of any surface in the sphere count, not those on the disc|return dot(n, photon_normal) > MIN_COSINE && height * height < MAX_HEIGHT * MAX_HEIGHT * radius2;|return true;
eta is that of the other way through the surface|return outside ? material.eta.x : 1.0 / material.eta.x;|return outside ? 1.0 / material.eta.x : material.eta.x;
a visible point forgets the throughput of its eye path|vec3 bsdf = work.state.throughput * material.color / PI;|vec3 bsdf = material.color / PI;
photons that are not on the disc are counted|sum.count += on_disc ? 1u : 0u;|sum.count += 1u;
the pdf of a light leaves out the chance that it is chosen|return light.direct_pmf * area_pdf *|return area_pdf *
survivors of Russian roulette keep their weight|path.weight = after < before ? weight * (before / after) : weight;|path.weight = weight;
a visible point stays where its eye path now finds none|store_visible_throughputs(pixel, has_point ? kept.throughput : vec4(0.0));|if (has_point) { store_visible_throughputs(pixel, kept.throughput); }
the radius shrinks by alpha where it should by 1 - alpha|float lost = (1.0 - alpha) * found / all;|float lost = alpha * found / all;
photons are compressed in glass as radiance is|material.color * (compression * masking_shadowing_weight(|material.color * (1.0 / (eta * eta) * masking_shadowing_weight(
photons bring direct light beside next-event estimation|bool is_wanted = DIRECT_NEE ? path.depth > 0u : true;|bool is_wanted = true;
the low word of a sum of flux does not carry|sum.high += high + mix(uvec3(0u), uvec3(1u), lessThan(sum.low, low));|sum.high += high;
LIST
}

# Copies the files that git knows or would add. Equal ones are left alone, so that cargo sees by
# their times what has changed.
restore() {
    git ls-files --cached --others --exclude-standard | while read -r file; do
        if [ -f "$file" ] && ! cmp -s "$file" "$copy/$file"; then
            mkdir -p "$(dirname "$copy/$file")"
            cp "$file" "$copy/$file"
        fi
    done
}

# The one file that contains a text.
file_of() {
    files=$(grep -rlF -e "$1" shaders) || files=
    if [ "$(echo "$files" | wc -w)" -ne 1 ]; then
        echo "$number. $name: the text to change is in ${files:-no file}: $1" >&2
        exit 1
    fi
    echo "$files"
}

number=0
breaks | while IFS='|' read -r name from to; do
    number=$((number + 1))
    file_of "$from" >/dev/null
done
if [ "$*" = check ]; then
    exit 0
fi

mkdir -p "$copy"
breaks >"$copy.list"
number=0
survivors=0
while IFS='|' read -r name from to <&3; do
    number=$((number + 1))
    case " $* " in "  " | *" $number "*) ;; *) continue ;; esac
    restore
    FROM=$from TO=$to perl -0777 -pi -e 's/\Q$ENV{FROM}\E/$ENV{TO}/' "$copy/$(file_of "$from")"
    log=$copy.log
    if (cd "$copy" && quick) >"$log" 2>&1; then
        echo "$number. $name: SURVIVES"
        survivors=$((survivors + 1))
    elif grep -q '^test result: FAILED' "$log"; then
        caught=$(sed -n 's/^    \([a-z_0-9:]*\)$/\1/p' "$log" | sort -u)
        echo "$number. $name: caught by $(echo "$caught" | wc -l): $(echo "$caught" | head -n 3 | tr '\n' ' ')"
    else
        tail -n 20 "$log" >&2
        echo "$number. $name: does not build" >&2
        exit 1
    fi
done 3<"$copy.list"
[ "$survivors" -eq 0 ]
