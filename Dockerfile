# Images of fenics_nnm. "docker build --tag fenics-nnm ." makes the last stage, "run"; Docker with
# BuildKit or without, Podman and buildah can do it.
#
# BASE may name the base image by its digest, for a build that can be repeated:
#     --build-arg BASE=debian:trixie-slim@sha256:...      ("docker pull" prints the digest)
# and SNAPSHOT a time, at which Debian's packages are taken from snapshot.debian.org:
#     --build-arg SNAPSHOT=20261115T000000Z
# Versions of all packages are in /opt/environment/installed-*.txt of each image. If the network
# needs a certificate of its own, put it into environment/certificates as a file *.crt.
ARG BASE=debian:trixie-slim


# What running a study takes, without the program itself.
FROM ${BASE} AS base

ARG SNAPSHOT=
COPY environment/debian-packages.txt environment/pip-packages.txt environment/pip-hashes.txt environment/install-pip environment/debian-snapshot /opt/environment/
COPY environment/certificates /opt/environment/certificates

# Packages for tests and checks stand at the end of the list.
RUN sh /opt/environment/debian-snapshot "$SNAPSHOT" \
    && apt-get update > /dev/null \
    && sed -e '/^# Tests, checks/,$d' -e 's/#.*//' /opt/environment/debian-packages.txt \
       | DEBIAN_FRONTEND=noninteractive xargs apt-get install --yes --no-install-recommends > /dev/null \
    && rm -rf /var/lib/apt/lists/* /var/cache/apt/*.bin \
    && dpkg-query --show > /opt/environment/installed-debian.txt

RUN cat /etc/ssl/certs/ca-certificates.crt $(find /opt/environment/certificates -name '*.crt') > /opt/environment/trusted.crt \
    && HOST_CA_BUNDLE=/opt/environment/trusted.crt sh /opt/environment/install-pip /opt/venv /opt/environment/pip-packages.txt ruff \
    && /opt/venv/bin/pip list --local --format=freeze > /opt/environment/installed-pip.txt

# Any user, known to the system or not, has a home for caches. MPI jobs may have
# more processes than there are cores.
RUN mkdir --mode=1777 /home/user
ENV HOME=/home/user \
    LC_ALL=C.UTF-8 \
    VIRTUAL_ENV=/opt/venv \
    PATH=/opt/venv/bin:/usr/local/bin:/usr/bin:/bin:/usr/sbin:/sbin \
    OMPI_ALLOW_RUN_AS_ROOT=1 \
    OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 \
    OMPI_MCA_btl=self,sm \
    PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe


# The same with what tests, checks and work in a checkout take; environment/run uses it.
FROM base AS environment

RUN apt-get update > /dev/null \
    && sed 's/#.*//' /opt/environment/debian-packages.txt \
       | DEBIAN_FRONTEND=noninteractive xargs apt-get install --yes --no-install-recommends > /dev/null \
    && rm -rf /var/lib/apt/lists/* /var/cache/apt/*.bin \
    && HOST_CA_BUNDLE=/opt/environment/trusted.crt sh /opt/environment/install-pip /opt/venv /opt/environment/pip-packages.txt


# The tests, for "docker build --target tests --tag fenics-nnm-tests ." and "docker run --rm
# fenics-nnm-tests": about ten minutes on two cores.
FROM environment AS tests

COPY . /opt/checkout
WORKDIR /opt/checkout
ENV PYTHONPATH=/opt/checkout \
    OMP_NUM_THREADS=1
CMD ["python3", "-m", "pytest", "-q", "-n", "auto", "--dist", "worksteal", "tests"]


# The program, for "docker run ... fenics-nnm run study.toml": the folder with the study is
# mounted on /work.
FROM base AS run

COPY pyproject.toml README.md LICENSE /opt/fenics_nnm/
COPY fenics_nnm /opt/fenics_nnm/fenics_nnm
RUN /opt/venv/bin/pip install --no-deps --no-build-isolation --no-cache-dir --quiet /opt/fenics_nnm \
    && rm -rf /opt/fenics_nnm \
    && useradd --home-dir /home/user --no-create-home user \
    && mkdir --mode=1777 /work

USER user
WORKDIR /work
ENTRYPOINT ["fenics-nnm"]
CMD ["--help"]
