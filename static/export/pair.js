// The buttons of a page of two flocks: each flock is a page of its own, in a frame.
const $ = (id) => document.getElementById(id);
let going = false;
const press = (button) => {
  going = button === "go";
  $("go").textContent = going ? "Pause both" : "Go both";
  for (const frame of document.getElementsByTagName("iframe")) frame.contentWindow.postMessage({ press: button }, "*");
};
$("go").onclick = () => press(going ? "pause" : "go");
$("step").onclick = () => press("step");
$("reset").onclick = () => press("reset");
