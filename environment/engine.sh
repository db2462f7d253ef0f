# shellcheck shell=bash
# The second way of environment/run: a container of Docker or Podman.

# Name of an engine that answers, or nothing.
answering_engine() {
    local engine
    for engine in docker podman; do
        have "$engine" || continue
        # "docker" may be Podman under another name.
        [[ $engine == podman || $(docker --version 2>/dev/null) != *[Pp]odman* ]] || continue
        if timeout 10 "$engine" info >/dev/null 2>&1; then
            echo "$engine"
            return
        fi
    done
}

# Arguments: the way asked for ("any" or "engine"), then the command. Returns
# if there is no engine, or no image and no way to build it.
run_in_engine() {
    local way=$1 hash engine image note
    shift
    hash=$(lists_hash)
    image="fenics-nnm-environment:$hash"
    note="$STATE/engine-$hash" # says that the image was built once
    # What is built already is used, rather than building something else.
    if [[ $way == any && -d $STATE/root-$hash && ! -e $note ]]; then return 0; fi

    engine=$(answering_engine)
    if [[ -z $engine ]]; then
        [[ $way == any ]] || say "neither docker nor podman answers"
        return 0
    fi
    if ! "$engine" image inspect "$image" >/dev/null 2>&1; then
        say "building the image $image with $engine"
        say "(once; it takes a few minutes and about 3 GB)"
        if ! guarded build_image "$engine" "$image" --target environment; then
            say "the image could not be built (see above)"
            return 0
        fi
    fi
    mkdir -p "$STATE/home"
    touch "$note"
    exec_in_container "$engine" "$image" "$@"
}

# Build image $2 of the Dockerfile with engine $1 (docker, podman or buildah);
# further arguments are passed on. The certificates of this machine are put where the
# Dockerfile looks for them.
build_image() {
    local engine=$1 image=$2 bundle place="$CHECKOUT/environment/certificates/host.crt"
    shift 2
    bundle=$(host_ca_bundle)
    if [[ -n $bundle ]] && ! cmp --silent "$bundle" "$place"; then
        cp "$bundle" "$place.part"
        mv "$place.part" "$place"
    fi
    "$engine" build --tag "$image" "$@" --file "$CHECKOUT/Dockerfile" "$CHECKOUT"
}

# The user that files of a container belong to, as options for engine $1.
user_options() {
    if [[ $1 == podman ]]; then
        [[ $EUID -eq 0 ]] || echo --userns=keep-id
        echo "--user=$(id -u):$(id -g)"
    elif docker info --format '{{.SecurityOptions}}' 2>/dev/null | grep -q rootless; then
        echo --user=0:0 # in Docker without root, this is the user who runs it
    else
        echo "--user=$(id -u):$(id -g)"
    fi
}

exec_in_container() {
    local engine=$1 image=$2 path name bundle
    local -a options
    shift 2
    case "$PWD" in
        / | /bin | /dev | /etc | /lib | /lib64 | /opt | /proc | /run | /sbin | /sys | /usr | /var)
            fail "cannot run in $PWD, which is a system folder in the container: go to another" ;;
    esac

    mapfile -t options < <(user_options "$engine")
    options+=(--rm --interactive --shm-size=1g --security-opt=label=disable)
    # A first process that passes signals on; Podman has it in a package of its own.
    if [[ $engine == docker || -x /usr/libexec/podman/catatonit ]] || have catatonit; then
        options+=(--init)
    fi
    if [[ -t 0 && -t 1 ]]; then options+=(--tty); fi
    while IFS= read -r path; do
        options+=(--mount "type=bind,src=$path,dst=$path")
    done < <(echo /tmp; visible_folders "$CHECKOUT" "$PWD")

    options+=(--env "HOME=$STATE/home" --env "PYTHONPATH=$CHECKOUT")
    options+=(--env "PATH=/opt/venv/bin:$CHECKOUT/environment/bin:/usr/local/bin:/usr/bin:/bin:/usr/sbin:/sbin")
    set_mpi_variables
    for name in OMPI_MCA_mca_base_env_list OMP_NUM_THREADS MPLBACKEND NO_COLOR TERM COLUMNS CI; do
        if [[ -n ${!name:-} ]]; then options+=(--env "$name"); fi
    done
    bundle=$(host_ca_bundle)
    if [[ -n $bundle ]]; then
        options+=(--mount "type=bind,src=$bundle,dst=/etc/ssl/certs/ca-certificates.crt,readonly")
        options+=(--env PIP_CERT=/etc/ssl/certs/ca-certificates.crt)
    fi
    export OMPI_MCA_mca_base_env_list OMP_NUM_THREADS
    exec "$engine" run "${options[@]}" --workdir "$PWD" "$image" "$@"
}
