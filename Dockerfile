# A container with uwsim, for Docker or Podman: docs/guides/install.md. The first build compiles for some minutes.
FROM debian:12
WORKDIR /uwsim
COPY . .
RUN apt-get update && apt-get install -y --no-install-recommends ca-certificates \
  && tools/setup && find build -name '*.o' -delete && rm -rf /var/lib/apt/lists/*
ENV PATH=/uwsim/.venv/bin:$PATH
WORKDIR /data
ENTRYPOINT ["uwsim"]
CMD ["--help"]
