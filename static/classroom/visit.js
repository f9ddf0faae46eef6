/* A student's laboratory, opened by the teacher. */
document.addEventListener("DOMContentLoaded", () => {
  const bar = document.createElement("div"), said = document.createElement("b");
  bar.className = "fs-class";
  said.textContent = "a student’s flock";
  bar.append(said);
  document.body.append(bar);
});
