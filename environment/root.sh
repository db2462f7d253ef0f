# shellcheck shell=bash
# The third way of environment/run: a private root folder with Debian 13 or, if asked for, another.

SUITE=trixie
SYSTEM="Debian 13"
ROOT_NAME=root # first part of the folder's name; roots of other names are left alone
ROOT_SIZE="3 GB"
ROOT_GIGABYTES=5 # free space asked for before a build

# Arguments: the command. Returns if this machine does not allow this way.
run_in_root() {
    local root bundle
    local -a namespace
    root="$STATE/$ROOT_NAME-$(lists_hash)"
    bundle=$(host_ca_bundle)
    choose_namespace || return 0
    if [[ ! -d $root ]]; then
        build_root "$root" || return 0
    fi

    exec 9<"$root"
    flock --shared 9 # held until the command ends, so that the root stays
    set_root_variables
    exec "${namespace[@]}" "$CHECKOUT/environment/enter-root" "$root" "$CHECKOUT" "$PWD" \
        "$bundle" "$@"
}

# From here on, the root is the one with ParaView and Chromium.
choose_viewers() {
    ROOT_NAME=viewers ROOT_SIZE="3 GB"
    DEBIAN_LIST="$CHECKOUT/environment/viewer-packages.txt" PIP_LIST=/dev/null
}

# From here on, the root is the one with Sphinx.
choose_docs() {
    ROOT_NAME=docs ROOT_SIZE="0.5 GB" ROOT_GIGABYTES=1
    DEBIAN_LIST="$CHECKOUT/environment/docs-packages.txt" PIP_LIST=/dev/null
}

# From here on, the root has the same lists from Debian's newest packages.
choose_next() {
    SUITE=sid SYSTEM="Debian unstable" ROOT_NAME=next ROOT_SIZE="4 GB"
}

# Set the array "namespace" to a command that runs another one with mounts of
# its own: these vanish with it and are never seen by the rest of the machine.
choose_namespace() {
    namespace=(unshare --mount --propagation private)
    if [[ $EUID -ne 0 ]]; then namespace+=(--map-root-user); fi
    if ! "${namespace[@]}" true 2>/dev/null; then
        ROOT_ADVICE="(not possible here: the system does not let this account make mount namespaces)"
        return 1
    fi
}

# What the command inside sees: nothing of the machine's compilers, libraries
# and Python settings.
set_root_variables() {
    unset LD_LIBRARY_PATH LD_PRELOAD PYTHONHOME PYTHONSTARTUP PETSC_DIR PETSC_ARCH SLEPC_DIR
    unset CC CXX CPPFLAGS CFLAGS CXXFLAGS LDFLAGS PKG_CONFIG_PATH CONDA_PREFIX TMPDIR
    unset XDG_CACHE_HOME XDG_CONFIG_HOME XDG_DATA_HOME XDG_RUNTIME_DIR
    mkdir -p "$STATE/home"
    export HOME="$STATE/home" LC_ALL=C.UTF-8 PYTHONPATH="$CHECKOUT" VIRTUAL_ENV=/opt/venv
    export OMPI_MCA_btl="${OMPI_MCA_btl:-self,sm}"
    if [[ $EUID -ne 0 ]]; then
        # Inside, every user is root: keep the temporary files of MPI jobs apart.
        export TMPDIR="/tmp/fenics-nnm-$EUID"
        mkdir -p -m 700 "$TMPDIR"
        [[ -O $TMPDIR ]] || fail "$TMPDIR belongs to someone else: remove it"
    fi
    set_mpi_variables

    local name bundle=/etc/ssl/certs/ca-certificates.crt # enter-root puts it there
    for name in SSL_CERT_FILE PIP_CERT REQUESTS_CA_BUNDLE CURL_CA_BUNDLE GIT_SSL_CAINFO; do
        if [[ -n ${!name:-} ]]; then export "$name=$bundle"; fi
    done
}

# Build the root folder $1, unless another process just did. Uses what run_in_root has set.
build_root() {
    local root=$1 partial="$1.partial"
    mkdir -p "$STATE"
    exec 8>"$STATE/build.lock"
    if ! flock --nonblock 8; then
        say "waiting for another build in $STATE"
        flock 8
    fi
    if [[ ! -d $root ]]; then
        check_space || return 1
        provide_mmdebstrap || return 1
        local stale
        for stale in "$STATE/$ROOT_NAME"-*.partial; do
            if [[ -d $stale ]]; then
                say "removing what an interrupted build left"
                remove_tree "$stale"
            fi
        done

        say "building a private $SYSTEM in $root"
        say "(once; it takes a few minutes and about $ROOT_SIZE)"
        if ! bootstrap "$partial"; then
            say "mmdebstrap failed (see above)"
            return 1
        fi
        if [[ -n $(list_of "$PIP_LIST") ]] && ! install_pip_list "$partial" "$bundle"; then
            say "pip failed (see above)"
            return 1
        fi
        mv -T "$partial" "$root"
        remove_old_roots "$root"
        say "ready"
    fi
    exec 8>&-
}

# Install the pip list into the new root $1, with certificates $2.
install_pip_list() {
    say "installing the list environment/pip-packages.txt"
    set_root_variables
    HOST_CA_BUNDLE=/etc/ssl/certs/ca-certificates.crt guarded \
        "${namespace[@]}" "$CHECKOUT/environment/enter-root" "$1" "$CHECKOUT" "$CHECKOUT" "$2" \
        sh "$CHECKOUT/environment/install-pip" /opt/venv "$PIP_LIST"
}

check_space() {
    local free
    free=$(df --output=avail --block-size=G "$STATE" | tail -n 1 | tr -dc 0-9)
    if ((free < ROOT_GIGABYTES)); then
        say "a private $SYSTEM needs $ROOT_GIGABYTES GB, but $STATE has only $free GB left"
        ROOT_ADVICE="(free some space: $ROOT_GIGABYTES GB are needed in $STATE)"
        return 1
    fi
}

# Make sure that mmdebstrap and Debian's keys are there.
provide_mmdebstrap() {
    local -a packages=()
    have mmdebstrap || packages+=(mmdebstrap)
    # Where Debian's keys are too old to know Debian 13, this brings new ones; unstable has the same.
    compgen -G "/usr/share/keyrings/debian-archive-trixie-*" >/dev/null || packages+=(debian-archive-keyring)
    if [[ $EUID -ne 0 ]] && ! have newuidmap; then packages+=(uidmap); fi
    if [[ ${#packages[@]} -gt 0 ]] && ! apt_install "${packages[@]}" &&
        { ! have mmdebstrap || [[ -z $(debian_keyring) ]]; }; then
        ROOT_ADVICE="sudo apt-get install ${packages[*]}   (or the like on other systems)"
        return 1
    fi
    if [[ $EUID -ne 0 ]] && ! grep -qE "^($(id -un)|$EUID):" /etc/subuid 2>/dev/null; then
        ROOT_ADVICE="sudo usermod --add-subuids 100000-165535 --add-subgids 100000-165535 $(id -un)"
        return 1
    fi
}

debian_keyring() {
    local file
    for file in /usr/share/keyrings/debian-archive-keyring.{gpg,pgp}; do
        if [[ -r $file ]]; then
            echo "$file"
            return
        fi
    done
}

# What this machine's apt is told about the age of lists, as options of mmdebstrap: a mirror that
# is kept as it was one day may have lists that ran out, as those of unstable do in a week.
options_about_age() {
    local name value
    have apt-config || return 0
    for name in Acquire::Check-Valid-Until Acquire::Check-Date; do
        value=
        eval "$(apt-config shell value "$name")"
        if [[ -n $value ]]; then echo "--aptopt=$name \"$value\""; fi
    done
}

# Unpack and set up Debian in the new folder $1.
bootstrap() {
    local partial=$1
    local -a ages
    mapfile -t ages < <(options_about_age)
    local -a command=(
        mmdebstrap --variant=apt
        --include="$(list_of "$DEBIAN_LIST" | paste -s -d ,)"
        --keyring="$(debian_keyring)"
        --aptopt='APT::Install-Recommends "false"'
        --aptopt='APT::Sandbox::User "root"'
        "${ages[@]}"
        --dpkgopt=force-unsafe-io
        --dpkgopt='path-exclude=/usr/share/man/*'
        --dpkgopt='path-exclude=/usr/share/locale/*'
        # shellcheck disable=SC2016
        --customize-hook='rm -rf "$1"/root/.[!.]*'
        # shellcheck disable=SC2016
        --customize-hook='touch "$1"/etc/resolv.conf "$1"/etc/hosts'
    )
    if [[ $EUID -eq 0 ]]; then
        # All its processes end with the first one, and all its mounts with them.
        END_SIGNAL=KILL guarded setpriv --pdeathsig KILL \
            unshare --mount --propagation private --pid --fork --kill-child \
            "${command[@]}" --mode=root "$SUITE" "$partial"
    else
        mkdir "$partial"
        # shellcheck disable=SC2016
        HOME=/ TMPDIR="${TMPDIR:-/var/tmp}" guarded bash -c 'set -o pipefail; partial=$1; shift
            "$@" | tar --extract --directory "$partial" --no-same-owner --exclude "./dev/*"' \
            bash "$partial" "${command[@]}" --mode=unshare --format=tar "$SUITE" -
    fi
}

# Remove the roots of older lists that no command uses any more.
remove_old_roots() {
    local old
    for old in "$STATE/$ROOT_NAME"-*; do
        if [[ $old != "$1" && $old != *.partial ]] && flock --nonblock "$old" true; then
            say "removing $old, which is out of date"
            mv -T "$old" "$old.partial"
            remove_tree "$old.partial"
        fi
    done
}

remove_tree() {
    [[ $EUID -eq 0 ]] || guarded chmod -R u+rwX "$1"
    guarded rm -rf --one-file-system "$1"
}
