/* viser draws more coarsely where drawing is slow. Here a picture is made, and nobody waits. */
{
  const get = URLSearchParams.prototype.get;
  URLSearchParams.prototype.get = function (name) {
    return name === "fixedDpr" ? "1" : get.call(this, name);
  };
}
