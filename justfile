# What developers run; each line is also a command of its own. `just` alone lists them.

[private]
default:
    @just --list

# install everything, as CI has it
setup:
    uv sync --locked --compile-bytecode

# physics, engine, rules, observables: no browser, no processes
quick:
    uv run pytest -m quick

# every test, as thoroughly as CI
test *options:
    uv run pytest --hypothesis-profile=ci {{options}}

# tests that look into a browser; without one they fail
browser:
    FLOCKSCOPE_BROWSER_TESTS=required uv run pytest -m browser

# style, types, the direction of imports
check:
    uv run ruff check
    uv run ruff format --check
    uv run mypy
    uv run lint-imports

# put style right
fix:
    uv run ruff check --fix
    uv run ruff format

# pages of the rules, after a declaration has changed
pages:
    uv run python docs/make.py
