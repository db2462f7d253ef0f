# Stage "environment": all that fenics_nnm needs, without fenics_nnm itself.
# environment/run uses it for work in a checkout. If the network needs a
# certificate of its own, give it to the build with
#     --secret id=ca,src=/etc/ssl/certs/ca-certificates.crt
FROM debian:trixie-slim AS environment

COPY environment/debian-packages.txt environment/pip-packages.txt environment/install-pip /opt/environment/

RUN apt-get update > /dev/null \
    && sed 's/#.*//' /opt/environment/debian-packages.txt \
       | DEBIAN_FRONTEND=noninteractive xargs apt-get install --yes --no-install-recommends > /dev/null \
    && rm -rf /var/lib/apt/lists/* /var/cache/apt/*.bin

RUN --mount=type=secret,id=ca \
    HOST_CA_BUNDLE=/run/secrets/ca sh /opt/environment/install-pip /opt/venv /opt/environment/pip-packages.txt

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


# The program itself, for "docker run ... fenics-nnm run study.toml": the folder
# with the study is mounted on /work.
FROM environment

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
