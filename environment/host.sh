# shellcheck shell=bash
# The first way of environment/run: the machine's own python3.

# Name of the Debian package that has a module.
debian_name() {
    case "$1" in
        mypy) echo mypy ;;
        PIL) echo python3-pil ;;
        petsc4py | slepc4py) echo "python3-$1-real" ;;
        xdist) echo python3-pytest-xdist ;;
        *) echo "python3-$1" ;;
    esac
}

# What tells one Python from another, on this machine or on one that shares the folder.
python_mark() { echo "$HOSTNAME:$(stat --dereference --format %d:%i "$python"):$python:${PYTHONPATH:-}"; }

# "No dolfinx" is remembered until one of Python's package folders changes,
# which saves starting Python each time.
host_known_without() {
    local note="$STATE/host-without-dolfinx" first=1 line
    [[ -f $note ]] || return 1
    while IFS= read -r line; do
        if [[ $first == 1 ]]; then
            [[ $line == "$(python_mark)" ]] || return 1
            first=0
        elif [[ ! $line -ot $note ]]; then
            return 1
        fi
    done <"$note"
}

remember_host_without() {
    mkdir -p "$STATE"
    {
        python_mark
        sed -n 's/^path //p' <<<"$found"
    } >"$STATE/host-without-dolfinx"
}

# Arguments: the way asked for ("any" or "host"), then the command. Returns if
# the machine's Python is not enough.
run_on_host() {
    local way=$1 python found version missing pip
    shift
    if ! python=$(command -v python3); then
        [[ $way == any ]] || say "this machine has no python3"
        return 0
    fi
    if [[ $way == any ]] && host_known_without; then return 0; fi

    local -a requirements
    mapfile -t requirements < <(list_of "$PIP_LIST")
    found=$("$python" "$CHECKOUT/environment/probe.py" "${requirements[@]}" 2>/dev/null) || found=
    version=$(sed -n 's/^dolfinx //p' <<<"$found")
    missing=$(sed -n 's/^missing //p' <<<"$found")
    pip=$(sed -n 's/^pip //p' <<<"$found")

    if [[ -z $version ]]; then
        [[ $way == any ]] || say "$python has no dolfinx"
        remember_host_without
        return 0
    fi
    if ! printf '0.9\n%s\n' "$version" | sort --version-sort --check=quiet; then
        say "$python has dolfinx $version, but 0.9 or newer is needed: not used"
        return 0
    fi
    if [[ -n $missing ]]; then
        explain_missing "$missing"
        return 0
    fi
    if [[ -n $pip ]] && ! enter_host_venv; then
        say "the packages of environment/pip-packages.txt could not be installed (see above)"
        return 0
    fi

    set_mpi_variables
    export PATH="$CHECKOUT/environment/bin:$PATH"
    export PYTHONPATH="$CHECKOUT${PYTHONPATH:+:$PYTHONPATH}"
    exec "$@"
}

explain_missing() {
    local module debian=''
    for module in $1; do
        debian+=" $(debian_name "$module")"
    done
    say "python3 has dolfinx but not:" $1 "- get it by 'apt-get install$debian' or" \
        "'conda env update --prefix \"\$CONDA_PREFIX\" --file $CHECKOUT/environment.yml'"
}

# Put a virtual environment with the pip list, made once, first on PATH.
enter_host_venv() {
    local venv
    venv="$STATE/venv-$({ lists_hash; "$python" -c 'import sys; print(sys.prefix, sys.version)'; } |
        sha256sum | cut -c 1-12)"
    if [[ ! -e $venv/complete ]]; then
        mkdir -p "$STATE"
        exec 8>"$STATE/build.lock"
        flock 8
        if [[ ! -e $venv/complete ]]; then
            say "installing the list environment/pip-packages.txt into $venv"
            rm -rf "$venv"
            HOST_CA_BUNDLE=$(host_ca_bundle) PATH="$(dirname "$python"):$PATH" \
                guarded sh "$CHECKOUT/environment/install-pip" "$venv" "$PIP_LIST" || return 1
            touch "$venv/complete"
        fi
        exec 8>&-
    fi
    export PATH="$venv/bin:$PATH" VIRTUAL_ENV="$venv"
}
