/* The page takes everything from where it came from and nothing from its address: viser's client
   would connect to ?websocket=, play ?playbackPath= and shrink to ?dummyWindowDimensions=. Behind a
   proxy it would also write ?websocket= into the address itself, and the page could not be loaded
   again. The scene that it names is kept for the gallery, which has the server look at it; a page
   that is loaded again, by somebody or after its server was away, leaves the run as it is by then. */
{
  const [arrival] = performance.getEntriesByType("navigation");
  const isNew = !arrival || arrival.type === "navigate";
  window.flockscopeScene = isNew ? new URLSearchParams(location.search).get("scene") : null;
  const replace = history.replaceState.bind(history);
  history.replaceState = (state, title) =>
    replace(state, title, location.origin + location.pathname);
  history.replaceState(null, "");
}
