# shellcheck shell=bash
# Helpers shared by environment/run and environment/image-check.

STATE="$CHECKOUT/.environment" # everything that the scripts build
DEBIAN_LIST="$CHECKOUT/environment/debian-packages.txt"
PIP_LIST="$CHECKOUT/environment/pip-packages.txt"
RECIPE=1 # raise it when the scripts build something different from the same lists

say() { printf 'environment: %s\n' "$*" >&2; }

fail() {
    say "$*"
    exit 2
}

have() { command -v "$1" >/dev/null 2>&1; }

# The lines of a list without comments and blanks.
list_of() { sed -e 's/#.*//' -e 's/[[:space:]]*$//' -e '/^$/d' "$@"; }

# A short name for the present content of both lists.
lists_hash() {
    { echo "$RECIPE"; list_of "$DEBIAN_LIST" "$PIP_LIST"; } | sha256sum | cut -c 1-12
}

# The certificates that this machine trusts, if there is a file of them.
host_ca_bundle() {
    local file
    for file in "${SSL_CERT_FILE:-}" "${PIP_CERT:-}" "${REQUESTS_CA_BUNDLE:-}" \
        /etc/ssl/certs/ca-certificates.crt /etc/pki/tls/certs/ca-bundle.crt; do
        if [[ -n $file && -s $file && -r $file ]]; then
            realpath -- "$file"
            return
        fi
    done
}

# True if folder $1 is folder $2 or lies below it.
is_inside() { [[ $1 == "$2" || $1 == "${2%/}"/* ]]; }

# The folders outside /tmp to show to a command: checkout $1 and current folder $2.
visible_folders() {
    if ! is_inside "$1" "$2"; then is_inside "$1" /tmp || echo "$1"; fi
    if ! is_inside "$2" "$1" || [[ $1 == "$2" ]]; then is_inside "$2" /tmp || echo "$2"; fi
}

# MPI jobs may run as root, may have more processes than the machine has cores,
# and use one thread per process unless OMP_NUM_THREADS says otherwise.
set_mpi_variables() {
    export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
    export PRTE_MCA_rmaps_default_mapping_policy="${PRTE_MCA_rmaps_default_mapping_policy:-:oversubscribe}"
    if [[ -z ${OMP_NUM_THREADS:-} ]]; then
        export OMPI_MCA_mca_base_env_list="${OMPI_MCA_mca_base_env_list:-OMP_NUM_THREADS=1}"
    fi
}

# Run a command that must not outlive this script: in a process group of its
# own, which is ended when this script is interrupted: by signal $END_SIGNAL, then
# by KILL. Output goes to stderr.
guarded() {
    local group status=0
    set -m
    "$@" </dev/null >&2 &
    group=$!
    set +m
    # shellcheck disable=SC2064  # the group is known now
    trap "end_group $group INT" INT
    # shellcheck disable=SC2064
    trap "end_group $group TERM" TERM
    # shellcheck disable=SC2064
    trap "end_group $group HUP" HUP
    wait "$group" || status=$?
    trap - INT TERM HUP
    return "$status"
}

# End process group $1, clean up, and end this script by signal $2.
end_group() {
    trap '' INT TERM HUP
    say "interrupted: stopping"
    disown -a
    kill "-${END_SIGNAL:-TERM}" -- "-$1" 2>/dev/null || true
    local tries
    for tries in {1..50}; do
        kill -0 -- "-$1" 2>/dev/null || break
        sleep 0.1
        if [[ $tries == 50 ]]; then kill -KILL -- "-$1" 2>/dev/null || true; fi
    done
    say "stopped"
    trap - "$2"
    kill "-$2" $$
}

# Install Debian packages on this machine: only as root and where there is apt.
apt_install() {
    [[ $EUID -eq 0 ]] && have apt-get || return 1
    say "installing on this machine by apt-get: $*"
    local log="$STATE/apt-get.log"
    mkdir -p "$STATE"
    export DEBIAN_FRONTEND=noninteractive
    # shellcheck disable=SC2016
    if ! guarded bash -c 'apt-get update &&
        apt-get -o DPkg::Lock::Timeout=120 install -y --no-install-recommends "$@"' \
        apt-get "$@" 2>"$log"; then
        say "apt-get failed; the end of its messages:"
        tail -n 5 "$log" >&2
        return 1
    fi
}
