/* The page takes everything from where it came from and nothing from its address: viser's client
   would connect to ?websocket=, play ?playbackPath= and shrink to ?dummyWindowDimensions=. Behind a
   proxy it would also write ?websocket= into the address itself, and the page could not be loaded
   again. */
{
  const replace = history.replaceState.bind(history);
  history.replaceState = (state, title) =>
    replace(state, title, location.origin + location.pathname);
  history.replaceState(null, "");
}
