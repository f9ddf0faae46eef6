# A class in a container: `flockscope class`, see docs/behind-a-proxy.md. That this file fits the project
# is tested (tests/packing/test_container.py); no test has built it.
#
#   docker build -t flockscope-class .
#   docker run --rm -p 8080:8080 -v flockscope-class:/class flockscope-class order --allow-host NAME
#
# What stands behind the image's name goes to `flockscope class`; NAME is the name by which students
# reach this machine, since a container does not know it.
FROM python:3.12-slim AS built

RUN pip install --no-cache-dir uv==0.13.9
WORKDIR /project
COPY pyproject.toml uv.lock README.md LICENSE ./
COPY packing packing
COPY flockscope flockscope
COPY app app
COPY agents agents
COPY worlds worlds
COPY static static
COPY experiments experiments
# Without the extra `film`: it brings an ffmpeg under the GPL, which an image that is passed on would hold.
ENV UV_PROJECT_ENVIRONMENT=/opt/flockscope UV_PYTHON_DOWNLOADS=never
RUN uv sync --locked --no-dev --no-editable --compile-bytecode --extra parquet

FROM python:3.12-slim

RUN useradd --create-home --uid 1000 teacher && install --directory --owner teacher /class
COPY --from=built /opt/flockscope /opt/flockscope
ENV PATH=/opt/flockscope/bin:$PATH PYTHONUNBUFFERED=1 FLOCKSCOPE_CACHE=/class/.cache
USER teacher
# Results of the class, and compiled models, which take seconds each to compile again.
WORKDIR /class
VOLUME /class
EXPOSE 8080
# Nothing is served without the code of the class, but it is answered that it is not. A class with a
# --certificate of its own takes `docker run --no-healthcheck`: this asks by plain HTTP.
HEALTHCHECK --interval=30s --timeout=5s --start-period=60s CMD ["python", "-c", \
    "import http.client as h; c = h.HTTPConnection('127.0.0.1', 8080, timeout=4); \
    c.request('GET', '/'); raise SystemExit(c.getresponse().status >= 500)"]
ENTRYPOINT ["flockscope", "class", "--host", "0.0.0.0", "--port", "8080", "--no-open"]
