/* Keys act again once something has been chosen from a list, and Escape and a click beside it close
   what is only there to be read: viser leaves the focus in the list's field, where letters are
   typed, and its windows open until the server closes them. */
{
  const release = () => setTimeout(() => {
    const field = document.activeElement;
    if (field && field.matches("input[aria-haspopup=listbox]")) field.blur();
  }, 0);
  const closeReading = () => {
    const page = document.querySelector(".mantine-Modal-content:has(.fs-page)");
    const buttons = page ? page.querySelectorAll("button") : [];
    if (buttons.length) buttons[buttons.length - 1].click();
    return buttons.length > 0;
  };
  window.addEventListener("click", (event) => {
    const at = event.target.closest ? event.target : document.body;
    if (at.closest("[role=option]")) release();
    const inner = at.closest(".mantine-Modal-inner, .mantine-Modal-overlay");
    if (inner && !at.closest(".mantine-Modal-content")) closeReading();
  }, true);
  window.addEventListener("keydown", (event) => {
    if (event.key === "Enter" && event.target.matches("input[aria-haspopup=listbox]")) release();
    if (event.key === "Escape" && closeReading()) event.stopPropagation();
  }, true);
}
