/** Messages in the order in which they came, also where the reading of one takes its time. */

export class MessageOrder<Message> {
  #held: Message[] | null = null; // what has come while something is read

  /** @param failed is told what reading has thrown, or rejected with; nothing is received any more then. */
  constructor(
    readonly receive: (message: Message) => void,
    readonly failed: (error: unknown) => void,
  ) {}

  /** Receive a message in its turn. */
  put(message: Message): void {
    if (this.#held) this.#held.push(message);
    else this.receive(message);
  }

  /** Read something, and take what it is before any message that comes from now on; at once where nothing is waited for. */
  read<Value>(read: () => Value | Promise<Value>, take: (value: Value) => void): void {
    let value: Value | Promise<Value>;
    try {
      value = read();
    } catch (error) {
      this.failed(error);
      return;
    }
    if (!(value instanceof Promise)) {
      take(value);
      return;
    }
    const held: Message[] = [];
    this.#held = held;
    value.then((value) => {
      this.#held = null;
      take(value);
      for (const message of held) this.put(message);
    }, this.failed);
  }
}
