/** Messages in order of arrival, even if reading one of them is asynchronous. */

export class MessageOrder<Message> {
  #held: Message[] | null = null; // messages that arrived during an asynchronous read

  /**
   * Deliver messages in order.
   *
   * @param failed is called with the error of a read; nothing is delivered afterwards.
   */
  constructor(
    readonly receive: (message: Message) => void,
    readonly failed: (error: unknown) => void,
  ) {}

  /** Receive a message in its turn. */
  put(message: Message): void {
    if (this.#held) this.#held.push(message);
    else this.receive(message);
  }

  /** Read a message, and take the result before any later message; synchronously if the read is. */
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
