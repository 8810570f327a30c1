// Entry point: registers commands, tasks and folding, and starts the language server.

import * as vscode from "vscode";
import { savedDeck } from "./deck";
import { foldingRanges } from "./folding";
import { LiveViews } from "./liveView";
import { ReportPanels } from "./report";
import { DeckServer } from "./server";
import { DeckTaskProvider, runDeckTask } from "./tasks";

/** Language of decks. */
const LANGUAGE = "abaqus";

let server: DeckServer | undefined;

/** Called by VS Code when the first deck is opened or a command is used. */
export function activate(context: vscode.ExtensionContext): void {
  const log = vscode.window.createOutputChannel("Revolve", { log: true });
  const running = new DeckServer(log);
  server = running;
  const deckCommand = (name: string, action: (deck: string) => Promise<unknown>) =>
    vscode.commands.registerCommand(name, async (resource?: vscode.Uri) => {
      const deck = await savedDeck(resource);
      return deck === undefined ? undefined : action(deck);
    });
  const liveViews = new LiveViews(log);
  const reports = new ReportPanels();
  const run = (deck: string) => runDeckTask("run", deck, running.runs);
  context.subscriptions.push(
    log,
    running,
    liveViews,
    deckCommand("revolve.run", run),
    deckCommand("revolve.check", (deck) => runDeckTask("check", deck, running.runs)),
    deckCommand("revolve.report", (deck) => reports.show(deck, () => run(deck))),
    deckCommand("revolve.liveView", (deck) => liveViews.show(deck)),
    vscode.commands.registerCommand("revolve.restartServer", () => running.restart()),
    vscode.tasks.registerTaskProvider("revolve", new DeckTaskProvider(() => running.runs)),
    vscode.languages.registerFoldingRangeProvider({ language: LANGUAGE }, {
      provideFoldingRanges: (document) => (running.folds ? [] : editorRanges(document.getText())),
    }),
    vscode.workspace.onDidChangeConfiguration((change) => {
      if (change.affectsConfiguration("revolve")) {
        void running.restart();
      }
    }),
    vscode.workspace.onDidGrantWorkspaceTrust(() => void running.restart()),
  );
  void running.restart();
}

/** Called by VS Code at its end. */
export function deactivate(): Promise<void> | undefined {
  return server?.stop();
}

function editorRanges(text: string): vscode.FoldingRange[] {
  const kind = (isComment: boolean) => (isComment ? vscode.FoldingRangeKind.Comment : undefined);
  return foldingRanges(text).map((range) => new vscode.FoldingRange(range.start, range.end, kind(range.isComment)));
}
