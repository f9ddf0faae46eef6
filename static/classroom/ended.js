/* Says over a laboratory's page that its class has ended: the page looks for its server no more. */
window.flockscopeEnded = (words, more) => {
  const sheet = document.createElement("div"), inner = document.createElement("div");
  const make = (kind, text) => Object.assign(document.createElement(kind), { textContent: text });
  document.documentElement.dataset.ended = "true";
  sheet.className = "fs-lost";
  sheet.setAttribute("role", "alert");
  inner.append(make("b", words), make("span", more));
  sheet.append(inner);
  document.body.append(sheet);
};
