# railgrip with both compilers of its models. From the folder of the project:
#     docker build -t railgrip .
#     docker run --rm -v "$PWD:/work" railgrip run trapezoid --out trapezoid
# The same with OpenModelica left out is `pip install '.[compiler]'` in any image that has Python.
FROM ubuntu:24.04

ARG OPENMODELICA=1.27.0
ARG DEBIAN_FRONTEND=noninteractive
SHELL ["/bin/bash", "-o", "pipefail", "-c"]

# As OpenModelica's own images install a release. omc calls cmake, make, zip and the C compiler that it
# was built with, clang or gcc, to make the binary of an FMU.
RUN apt-get update -q \
    && apt-get install -qy --no-install-recommends ca-certificates curl git gnupg make python3 python3-venv \
    && curl -fsSL https://build.openmodelica.org/apt/openmodelica.asc \
       | gpg --dearmor -o /usr/share/keyrings/openmodelica-keyring.gpg \
    && echo "deb [arch=amd64 signed-by=/usr/share/keyrings/openmodelica-keyring.gpg] https://build.openmodelica.org/omc/builds/linux/releases/${OPENMODELICA}/ noble release" \
       > /etc/apt/sources.list.d/openmodelica.list \
    && apt-get update -q \
    && apt-get install -qy --no-install-recommends omc clang gcc libc6-dev cmake zip \
    && rm -rf /var/lib/apt/lists/*

COPY pyproject.toml setup.py README.md LICENSE /usr/src/railgrip/
COPY harness /usr/src/railgrip/harness
COPY estimators /usr/src/railgrip/estimators
COPY controllers /usr/src/railgrip/controllers
COPY fmus /usr/src/railgrip/fmus
COPY modelica /usr/src/railgrip/modelica
RUN python3 -m venv /opt/railgrip \
    && /opt/railgrip/bin/python -m pip install --no-cache-dir "/usr/src/railgrip[compiler,parquet,mf4]"

# The installation belongs to root; FMUs and results of the loop are kept where the user may write.
RUN mkdir /work /cache && chmod 777 /work /cache
ENV PATH=/opt/railgrip/bin:$PATH RAILGRIP_CACHE=/cache/railgrip
USER 1000
WORKDIR /work
ENTRYPOINT ["railgrip"]
CMD ["doctor"]
