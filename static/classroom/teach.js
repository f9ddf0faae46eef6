/* The teacher's key has come with the address: it is sent as a form, so that a cookie that only our
   own pages bring is there at the next page, wherever the address was opened from. */
document.addEventListener("DOMContentLoaded", () => {
  history.replaceState(null, "", "./");
  document.forms[0].submit();
});
