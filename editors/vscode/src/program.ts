// The program `revolve`: its path, its environment, and calls whose output the extension reads.

import { execFile } from "node:child_process";
import * as os from "node:os";
import * as path from "node:path";
import * as vscode from "vscode";

/** Program with the variables that are added to the environment of its processes. */
export interface RevolveProgram {
  path: string;
  variables: Record<string, string>;
}

/** Output of a process that has ended. */
export interface ProcessOutput {
  /** Exit status, or "missing" if the program could not be started. */
  status: number | "missing";
  stdout: string;
  stderr: string;
}

/** Returns the program that the settings name. In an untrusted workspace it restricts what a deck can do. */
export function configuredProgram(): RevolveProgram {
  const setting = vscode.workspace.getConfiguration("revolve").get<string>("path")?.trim() || "revolve";
  const folder = vscode.workspace.workspaceFolders?.[0]?.uri.fsPath;
  const variables: Record<string, string> = vscode.workspace.isTrusted ? {} : { REVOLVE_UNTRUSTED: "1" };
  return { path: resolvePath(setting, os.homedir(), folder), variables };
}

/** Resolves a setting: a bare name is searched in PATH, `~/` is the home folder, other paths are relative to `folder`. */
export function resolvePath(setting: string, home: string, folder: string | undefined): string {
  if (/^~[\\/]/.test(setting)) {
    return path.join(home, setting.slice(2));
  }
  const isBareName = !/[\\/]/.test(setting);
  return isBareName || path.isAbsolute(setting) || folder === undefined ? setting : path.join(folder, setting);
}

/** Returns the environment of a process of the program. */
export function environment(program: RevolveProgram): NodeJS.ProcessEnv {
  return { ...process.env, ...program.variables };
}

/** Runs the program without a shell and returns what it printed. */
export function capture(program: RevolveProgram, words: string[], cwd?: string): Promise<ProcessOutput> {
  const options = { cwd, env: environment(program), maxBuffer: 64 << 20 };
  return new Promise((resolve) => {
    execFile(program.path, words, options, (error, stdout, stderr) => {
      const code = error?.code ?? (error ? 1 : 0);
      resolve({ status: typeof code === "number" ? code : "missing", stdout, stderr });
    });
  });
}

/** Returns whether the program has a command. */
export async function hasCommand(program: RevolveProgram, command: string): Promise<boolean | "missing"> {
  const { status } = await capture(program, [command, "--help"]);
  return status === "missing" ? status : status === 0;
}

/** Shows that the program was not found. */
export async function reportMissing(program: RevolveProgram): Promise<void> {
  const settings = "Open settings";
  const text = `The program \`${program.path}\` was not found. Install Revolve, or set \`revolve.path\`.`;
  if ((await vscode.window.showErrorMessage(text, settings)) === settings) {
    await vscode.commands.executeCommand("workbench.action.openSettings", "revolve.path");
  }
}

/** Shows that the installed program is older than a command. */
export async function reportUnknownCommand(program: RevolveProgram, command: string, use: string): Promise<void> {
  const version = (await capture(program, ["--version"])).stdout.split("\n")[0].trim() || program.path;
  void vscode.window.showWarningMessage(
    `${version} does not know the command \`revolve ${command}\`, so ${use}. Install a newer version of Revolve.`,
  );
}
