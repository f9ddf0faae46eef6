/* viser writes labels into its canvas, black on white boxes. Here the boxes become pills with a rim, by
   what its shaders are given; where a shader is not as it was, its labels stay as they were. And labels
   are drawn a picture later: viser moves them one picture before what they stand beside. */
{
  const gl = WebGL2RenderingContext.prototype;
  const edits = [
    ["varying float vAlpha;", `varying float vAlpha;
varying vec2 vCorner;
varying vec2 vBox;`],
    ["vec2 local = (aRect.xy + corner * aRect.zw) * scale;", `vec4 box = aRect;
  if (aUvRect == vec4(0.0)) {
    float ends = 0.32 * box.w;
    box += vec4(-ends, 0.0, 2.0 * ends, 0.0);
  }
  vCorner = corner * box.zw;
  vBox = box.zw;
  vec2 local = (box.xy + corner * box.zw) * scale;`],
    ["gl_FragColor = vec4(1.0, 1.0, 1.0, 0.85 * vAlpha);", `float ends = 0.5 * min(vBox.x, vBox.y);
  vec2 past = max(abs(vCorner - 0.5 * vBox) - 0.5 * vBox + ends, 0.0);
  float away = length(past) - ends;
  float pixel = max(fwidth(vCorner.y), 1e-4);
  float rim = smoothstep(-2.0, -1.0, away / pixel);
  vec3 ground = mix(vec3(0.965, 0.975, 0.99), vec3(0.62, 0.68, 0.76), rim);
  gl_FragColor = vec4(ground, 0.94 * vAlpha * smoothstep(0.0, -1.0, away / pixel));`],
  ];
  const compile = gl.shaderSource;
  gl.shaderSource = function (shader, source) {
    const ours = source.includes("uLabelData") || source.includes(edits[2][0]);
    const made = ours ? edits.reduce((text, [from, to]) => text.replace(from, to), source) : source;
    return compile.call(this, shader, made);
  };
  const LABELS = 4096;
  const write = gl.texSubImage2D;
  let last = null;
  gl.texSubImage2D = function (...given) {
    const places = given[8];
    if (given[4] === LABELS && given[5] === 1 && places instanceof Float32Array) {
      given[8] = last || places.slice();
      last = places.slice();
    }
    return write.apply(this, given);
  };
}
