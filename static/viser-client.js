/* The only way of our scripts to viser's client, which is a worker of this page. viser has no public
   interface for it: a page hears what the client hands to it, and hands it messages as a server would.
   A version of viser with such an interface makes this file unnecessary. */
{
  const receivers = [], senders = [];
  let first = null, client = null;
  const Worker = window.Worker;
  window.Worker = class extends Worker {
    constructor(...given) {
      super(...given);
      first = first || this;
      this.addEventListener("message", ({ data }) => {
        if (!data) return;
        if (data.type === "message_batch") client = this;
        for (const receive of receivers) receive(data);
      });
    }
    postMessage(data, ...more) {
      if (data && data.message) for (const notice of senders) notice(data.message);
      super.postMessage(data, ...more);
    }
  };
  window.viserClient = {
    isThere: () => client !== null,
    /* `receive` is called with all that the client hands to the page: `connected`, `closed`, batches. */
    onData: (receive) => receivers.push(receive),
    /* `receive` is called with each message of the server, before the page has it. It may change it. */
    onMessage: (receive) => receivers.push((data) => {
      if (data.type === "message_batch") for (const message of data.messages) receive(message);
    }),
    /* `notice` is called with each message that the page sends to the server. */
    onSend: (notice) => senders.push(notice),
    /* The page takes these messages as if the server had sent them. */
    show: (...messages) => client.dispatchEvent(
      new MessageEvent("message", { data: { type: "message_batch", messages } })),
    /* The server gets this message. */
    send: (message) => client.postMessage({ type: "send", message }),
    /* The client connects anew, or for the first time. */
    reconnect: () => (client || first)?.postMessage({ type: "retry" }),
  };
}
