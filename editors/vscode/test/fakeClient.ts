// The class `LanguageClient` without a server: it records how a server would be started.

/** Clients in the order of their start. */
export const clients: LanguageClient[] = [];

export class LanguageClient {
  /** Capabilities that the server would state. */
  static capabilities: Record<string, unknown> = {};
  private running = false;
  initializeResult: { capabilities: Record<string, unknown> } | undefined;

  constructor(
    readonly id: string,
    readonly name: string,
    readonly server: { command: string; args: string[]; transport?: unknown; options: { env: Record<string, string> } },
    readonly options: { initializationOptions: unknown; documentSelector: unknown[] },
  ) {}

  async start(): Promise<void> {
    this.running = true;
    this.initializeResult = { capabilities: LanguageClient.capabilities };
    clients.push(this);
  }

  async stop(): Promise<void> {
    this.running = false;
  }

  isRunning(): boolean {
    return this.running;
  }
}
