# One image for the API and the workers.
FROM node:22-bookworm-slim AS viewer
WORKDIR /src/web_client
COPY web_client/package.json web_client/package-lock.json ./
RUN npm ci --no-audit --no-fund
COPY web_client ./
RUN npm run build

FROM python:3.11-slim-bookworm AS build
RUN apt-get update && apt-get install -y --no-install-recommends g++ && rm -rf /var/lib/apt/lists/*
WORKDIR /src
COPY pyproject.toml CMakeLists.txt README.md LICENSE ./
COPY hgs_core hgs_core
COPY jobs jobs
COPY server server
COPY --from=viewer /src/server/viewer server/viewer
# torch for the CPU comes from an index of its own: the default one's brings gigabytes of CUDA. TORCH=cuda wants those.
ARG TORCH=cpu
RUN python -m venv /opt/hgs && case "$TORCH" in \
        cpu) /opt/hgs/bin/pip install --no-cache-dir torch==2.13.0 --index-url https://download.pytorch.org/whl/cpu;; \
        cuda) /opt/hgs/bin/pip install --no-cache-dir torch==2.13.0;; \
        *) echo "TORCH=$TORCH: give cpu or cuda" >&2; exit 1;; \
    esac \
    && /opt/hgs/bin/pip install --no-cache-dir ".[postgres]"

FROM python:3.11-slim-bookworm
RUN apt-get update && apt-get install -y --no-install-recommends libgl1 libglib2.0-0 libgomp1 \
    && rm -rf /var/lib/apt/lists/* && useradd --create-home --uid 10001 hgs && mkdir /data && chown hgs /data
COPY --from=build /opt/hgs /opt/hgs
ENV PATH=/opt/hgs/bin:$PATH HGS_HOME=/data
USER hgs
EXPOSE 8000
CMD ["hgs", "serve", "--host", "0.0.0.0", "--workers", "0"]
