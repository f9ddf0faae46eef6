/* Loads the page again once there is another flock for this student than the one it stands for. */
document.addEventListener("DOMContentLoaded", () => {
  const listen = () => {
    const line = new EventSource("class/mine");
    line.onmessage = (event) => {
      const { page, flock, over, removed } = JSON.parse(event.data);
      if (over) {
        line.close();
        document.querySelector("[role=status]").textContent = removed ?
          "You are no longer in this class. The code on the wall lets you in again." : "The class has ended.";
        return;
      }
      if (page === "flock" && (!flock || flock === document.body.dataset.flock)) return;
      line.close();
      location.reload();
    };
    line.onerror = () => { if (line.readyState === EventSource.CLOSED) setTimeout(listen, 2000); };
  };
  listen();
});
