"""Labels in the picture: viser's shaders, as the page changes them, are ones that WebGL takes."""

from __future__ import annotations

import re

import pytest

from app.front.client_page import Scripts, unpack_client, viser_page

COMPILE = """([kind, source]) => {
  const gl = document.createElement("canvas").getContext("webgl2");
  const shader = gl.createShader(gl[kind]);
  gl.shaderSource(shader, source);
  gl.compileShader(shader);
  return [gl.getShaderParameter(shader, gl.COMPILE_STATUS), gl.getShaderSource(shader)];
}"""
BEFORE = {
    "VERTEX_SHADER": """#version 300 es
#define attribute in
#define varying out
#define texture2D texture
precision highp float;
uniform mat4 viewMatrix, projectionMatrix;
in vec3 position;
""",
    "FRAGMENT_SHADER": """#version 300 es
#define varying in
precision highp float;
out vec4 colour;
#define gl_FragColor colour
""",
}
"""What three.js puts before a shader, as far as these need it."""


def shaders() -> dict[str, str]:
    """The shaders of labels in viser's client, by kind."""
    ((attributes, _),) = Scripts.of(viser_page())
    client = unpack_client(attributes).decode()
    texts = re.findall(r"`(\s*(?:attribute|varying) [^`$]*(?:\$\{[^`]*?\}[^`$]*)*)`", client)
    (vertex,) = [one for one in texts if "uLabelData" in one]
    (ground,) = [one for one in texts if "0.85 * vAlpha" in one]
    vertex = re.sub(r"\$\{[^}]*\}", "1000.0", vertex)
    return {"VERTEX_SHADER": vertex, "FRAGMENT_SHADER": ground}


@pytest.mark.parametrize("kind", list(BEFORE))
def test_the_ground_of_a_label_is_a_pill(window, kind):
    works, taken = window.page.evaluate(COMPILE, [kind, BEFORE[kind] + shaders()[kind]])
    assert works
    assert "vBox" in taken
    assert "0.85 * vAlpha" not in taken
