// The deck that a command acts on.

import * as vscode from "vscode";

/** Returns the path of the deck of a command, saved to its file; `undefined` after a message if there is none. */
export async function savedDeck(resource?: vscode.Uri): Promise<string | undefined> {
  const uri = resource ?? vscode.window.activeTextEditor?.document.uri;
  if (uri === undefined) {
    void vscode.window.showErrorMessage("No deck is open. Open an input deck (.inp) first.");
    return undefined;
  }
  if (uri.scheme !== "file") {
    void vscode.window.showErrorMessage("The deck is not a file on a disk. Save it first.");
    return undefined;
  }
  const document = vscode.workspace.textDocuments.find((open) => open.uri.toString() === uri.toString());
  if (document?.isDirty && !(await document.save())) {
    void vscode.window.showErrorMessage(`${uri.fsPath} could not be saved.`);
    return undefined;
  }
  return uri.fsPath;
}
