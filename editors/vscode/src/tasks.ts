// Tasks `revolve run` and `revolve check`: made by the commands of the extension, and defined in tasks.json.

import * as os from "node:os";
import * as path from "node:path";
import * as vscode from "vscode";
import { absoluteCommandLine, deckCommandLine } from "./commandLine";
import { configuredProgram, hasCommand, reportMissing } from "./program";

/** Definition of a task in tasks.json. */
export interface DeckTaskDefinition extends vscode.TaskDefinition {
  command: "run" | "check";
  /** Path, absolute or relative to the workspace folder. */
  deck: string;
  /** Further arguments of the command. */
  arguments?: string[];
}

/**
 * Creates a task that starts the program without a shell, so that no name needs quotes. The output of the program becomes
 * diagnostics unless the language server publishes them.
 */
export function createDeckTask(
  definition: DeckTaskDefinition,
  folder: vscode.WorkspaceFolder | undefined,
  serverRuns: boolean,
): vscode.Task {
  const deck = path.resolve(folder?.uri.fsPath ?? ".", definition.deck);
  const program = configuredProgram();
  const hasFolder = Boolean(vscode.workspace.workspaceFolders?.length);
  const { words, cwd } = hasFolder
    ? deckCommandLine(definition.command, deck, definition.arguments)
    : { words: absoluteCommandLine(definition.command, deck, definition.arguments), cwd: os.homedir() };
  const execution = new vscode.ProcessExecution(program.path, words, { cwd, env: program.variables });
  const label = `${definition.command} ${path.basename(deck)}`;
  const matchers = serverRuns ? [] : ["$revolve"];
  const task = new vscode.Task(definition, folder ?? vscode.TaskScope.Workspace, label, "revolve", execution, matchers);
  task.presentationOptions = { reveal: vscode.TaskRevealKind.Always, panel: vscode.TaskPanelKind.Dedicated, clear: true };
  return task;
}

/** Runs a command for a deck as a task; returns its exit status, `undefined` if it was not started or was stopped. */
export async function runDeckTask(
  command: DeckTaskDefinition["command"],
  deck: string,
  serverRuns: boolean,
): Promise<number | undefined> {
  const program = configuredProgram();
  if ((await hasCommand(program, command)) === "missing") {
    void reportMissing(program);
    return undefined;
  }
  const folder = vscode.workspace.getWorkspaceFolder(vscode.Uri.file(deck));
  const named = folder === undefined ? deck : path.relative(folder.uri.fsPath, deck);
  const task = createDeckTask({ type: "revolve", command, deck: named }, folder, serverRuns);
  const execution = await vscode.tasks.executeTask(task);
  return new Promise((resolve) => {
    const end = (status: number | undefined) => {
      processEnd.dispose();
      taskEnd.dispose();
      resolve(status);
    };
    const processEnd = vscode.tasks.onDidEndTaskProcess((e) => e.execution === execution && end(e.exitCode));
    const taskEnd = vscode.tasks.onDidEndTask((e) => e.execution === execution && end(undefined));
  });
}

/** Completes the tasks of tasks.json, and offers both commands for the deck in the editor. */
export class DeckTaskProvider implements vscode.TaskProvider {
  constructor(private readonly serverRuns: () => boolean) {}

  provideTasks(): vscode.Task[] {
    const document = vscode.window.activeTextEditor?.document;
    const folder = document && vscode.workspace.getWorkspaceFolder(document.uri);
    if (document?.languageId !== "abaqus" || folder === undefined) {
      return [];
    }
    const deck = path.relative(folder.uri.fsPath, document.uri.fsPath);
    const commands: DeckTaskDefinition["command"][] = ["run", "check"];
    return commands.map((command) => createDeckTask({ type: "revolve", command, deck }, folder, this.serverRuns()));
  }

  resolveTask(task: vscode.Task): vscode.Task | undefined {
    const { command, deck } = task.definition as Partial<DeckTaskDefinition>;
    if ((command !== "run" && command !== "check") || typeof deck !== "string") {
      return undefined;
    }
    const folder = typeof task.scope === "object" ? task.scope : vscode.workspace.workspaceFolders?.[0];
    // The definition must be the same object: VS Code compares it.
    return createDeckTask(task.definition as DeckTaskDefinition, folder, this.serverRuns());
  }
}
