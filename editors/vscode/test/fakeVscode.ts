// The part of the module `vscode` that the extension uses. Messages, panels and tasks are recorded; tasks start processes.

import { spawn } from "node:child_process";
import { readFileSync } from "node:fs";
import { homedir } from "node:os";
import * as path from "node:path";

type Listener<T> = (event: T) => unknown;

/** An event as VS Code offers it, with a function that fires it. */
class FakeEvent<T> {
  private readonly listeners = new Set<Listener<T>>();
  readonly subscribe = (listener: Listener<T>) => {
    this.listeners.add(listener);
    return { dispose: () => this.listeners.delete(listener) };
  };
  fire(event: T): void {
    [...this.listeners].forEach((listener) => listener(event));
  }
}

export class Uri {
  private constructor(readonly scheme: string, readonly fsPath: string, private readonly text: string) {}
  static file(name: string): Uri {
    return new Uri("file", name, `file://${name}`);
  }
  static parse(text: string): Uri {
    return new Uri(text.split(":")[0], "", text);
  }
  toString(): string {
    return this.text;
  }
}

export class ProcessExecution {
  constructor(
    readonly process: string,
    readonly args: string[],
    readonly options: { cwd: string; env: Record<string, string> },
  ) {}
}

export class Task {
  presentationOptions: unknown;
  constructor(
    readonly definition: { type: string },
    readonly scope: unknown,
    readonly name: string,
    readonly source: string,
    readonly execution: ProcessExecution,
    readonly problemMatchers: string[],
  ) {}
}

export class FoldingRange {
  constructor(readonly start: number, readonly end: number, readonly kind?: number) {}
}

export const FoldingRangeKind = { Comment: 1 };
export const TaskScope = { Workspace: 2 };
export const TaskRevealKind = { Always: 1 };
export const TaskPanelKind = { Dedicated: 2 };
export const ViewColumn = { Beside: -2 };

/** Panel with its page. */
export interface FakePanel {
  type: string;
  title: string;
  options: { enableScripts: boolean; localResourceRoots: unknown[] };
  webview: { html: string };
  reveals: number;
  dispose(): void;
}

/** What the extension has done, and what the person answers. */
export const recorded = {
  messages: [] as string[],
  answer: undefined as string | undefined,
  panels: [] as FakePanel[],
  tasks: [] as { task: Task; output: string }[],
  settings: { path: "revolve", mode: "auto" } as Record<string, string>,
  commands: new Map<string, (...words: unknown[]) => unknown>(),
  providers: new Map<string, unknown>(),
  executed: [] as string[],
  saved: 0,
};

const [processEnd, taskEnd] = [new FakeEvent<unknown>(), new FakeEvent<unknown>()];
export const [settingsChange, trustGrant] = [new FakeEvent<unknown>(), new FakeEvent<unknown>()];

const message = async (text: string, ...buttons: string[]) => {
  recorded.messages.push(text);
  return buttons.find((button) => button === recorded.answer);
};

export const window = {
  activeTextEditor: undefined as { document: unknown } | undefined,
  showErrorMessage: message,
  showWarningMessage: message,
  showInformationMessage: message,
  createOutputChannel: () => ({ info() {}, warn() {}, error() {}, dispose() {} }),
  createWebviewPanel(type: string, title: string, _place: unknown, options: FakePanel["options"]) {
    const closed = new FakeEvent<void>();
    const panel = {
      type,
      title,
      options,
      webview: { html: "" },
      reveals: 0,
      reveal: () => (panel.reveals += 1),
      onDidDispose: closed.subscribe,
      dispose: () => closed.fire(),
    };
    recorded.panels.push(panel);
    return panel;
  },
};

export const workspace = {
  isTrusted: true,
  workspaceFolders: undefined as { uri: Uri }[] | undefined,
  textDocuments: [] as unknown[],
  getConfiguration: () => ({ get: (name: string, other?: string) => recorded.settings[name] ?? other }),
  getWorkspaceFolder: (uri: Uri) =>
    workspace.workspaceFolders?.find((folder) => uri.fsPath.startsWith(folder.uri.fsPath + path.sep)),
  onDidChangeConfiguration: settingsChange.subscribe,
  onDidGrantWorkspaceTrust: trustGrant.subscribe,
};

export const commands = {
  registerCommand(name: string, action: (...words: unknown[]) => unknown) {
    recorded.commands.set(name, action);
    return { dispose() {} };
  },
  executeCommand: async (...words: string[]) => void recorded.executed.push(words.join(" ")),
};

export const tasks = {
  onDidEndTaskProcess: processEnd.subscribe,
  onDidEndTask: taskEnd.subscribe,
  registerTaskProvider(type: string, provider: unknown) {
    recorded.providers.set(type, provider);
    return { dispose() {} };
  },
  /** Starts the process of a task as VS Code does: without a shell. */
  async executeTask(task: Task) {
    const execution = { task };
    const { process: program, args, options } = task.execution;
    const isEmpty = !workspace.workspaceFolders?.length;
    if (isEmpty && options.cwd !== homedir()) {
      throw new Error("a window without a folder starts tasks in the home folder only");
    }
    const child = spawn(program, args, { cwd: options.cwd, env: { ...process.env, ...options.env } });
    let output = "";
    child.stdout.on("data", (data) => (output += data));
    child.on("close", (exitCode) => {
      recorded.tasks.push({ task, output });
      processEnd.fire({ execution, exitCode });
      taskEnd.fire({ execution });
    });
    return execution;
  },
};

export const languages = {
  registerFoldingRangeProvider(_selector: unknown, provider: unknown) {
    recorded.providers.set("folding", provider);
    return { dispose() {} };
  },
};

export const env = { asExternalUri: async (uri: Uri) => uri };

/** Document of a file, as open in an editor. */
export function openDocument(file: string, isDirty = false) {
  const document = {
    uri: Uri.file(file),
    languageId: "abaqus",
    isDirty,
    getText: () => readFileSync(file, "utf8"),
    save: async () => {
      recorded.saved += 1;
      return true;
    },
  };
  workspace.textDocuments.push(document);
  window.activeTextEditor = { document };
  return document;
}
