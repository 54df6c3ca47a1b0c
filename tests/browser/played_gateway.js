// A gateway in the page's own process: it takes the place of WebSocket before the page is loaded. OPENING is its snapshot.
(() => {
  const played = window.played = {
    opening: OPENING, sequence: 1, clock: OPENING.clock, since: 0, heard: [], replies: [], mute: false,
  };
  const sockets = new Set();
  const clock = () => played.clock + (performance.now() - played.since) / 1000;
  const say = message => sockets.forEach(socket => socket.onmessage({data: JSON.stringify(message)}));
  const snapshot = () => say({...played.opening, sequence: played.sequence, clock: clock()});

  played.say = say;
  played.change = (topics, at, since) => {
    if (at !== null) [played.clock, played.since] = [at, performance.now()];
    Object.assign(played.opening.topics, topics);
    const before = since ?? played.sequence++;
    say({type: "changes", since: before, sequence: played.sequence, clock: clock(), topics});
  };

  window.WebSocket = class {
    static OPEN = 1;
    readyState = 0;
    constructor() {
      setTimeout(() => {
        this.readyState = 1;
        sockets.add(this);
        if (!played.mute) snapshot();
      });
    }
    send(text) {
      const message = JSON.parse(text);
      played.heard.push(message);
      if (message.type === "refresh") snapshot();
      const answers = "id" in message ? played.replies : [];
      for (const [outcome, reason] of answers) say({type: "answer", id: message.id, outcome, reason});
    }
    close() {
      sockets.delete(this);
      setTimeout(() => this.onclose?.({}));
    }
  };

  const alive = () => say({type: "changes", since: played.sequence, sequence: played.sequence, clock: clock(), topics: {}});
  setInterval(() => played.mute || alive(), 500);
})();
