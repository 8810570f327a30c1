"""Continuous checking of the program: random scenes, killed searches, growth. Prints a table; failures are saved as decks."""

import argparse
import collections
import contextlib
import math
import os
import random
import shutil
import sys
import tempfile
import time

import growth
import judge
import kills
import scenes

KINDS = (
    "closed",
    "closed, with a warning",
    "warned of a term",
    "warned of drift",
    "halted",
    "slow",
    "refused",
    "failed",
)


class Soak:
    """The checks of random scenes and their counts."""

    def __init__(self, options):
        self.options = options
        self.counts = collections.Counter()
        self.features = collections.Counter()
        self.warnings = collections.Counter()
        self.more = collections.Counter()
        self.failures = []
        self.increments = 0

    def check(self, number):
        options = self.options
        scene = scenes.scene(options.seed, number)
        with tempfile.TemporaryDirectory(prefix="soak-") as folder:

            def write(text, name):
                path = os.path.join(folder, f"{name}.inp")
                with open(path, "w", encoding="utf-8") as file:
                    file.write(text)
                return path

            def again():
                deck = write(scene.deck(None), "each")
                return judge.run(options.program, deck, os.path.join(folder, "each"), 10 * options.limit)

            deck = write(scene.deck(), "scene")
            done = judge.run(options.program, deck, os.path.join(folder, "out"), options.limit)
            verdict = judge.judge(done, scene, again)
            if verdict.kind not in ("slow", "refused", "failed") and done.summary:
                self.further(number, scene, done, write, folder, deck, verdict)
            kind = "failed" if verdict.failures else verdict.kind
            self.counts[kind] += 1
            self.features.update(scene.features)
            self.warnings.update(verdict.warnings)
            self.increments += verdict.increments
            if verdict.failures or kind == "refused" and options.keep_refused:
                self.save(number, scene, verdict, done)

    def further(self, number, scene, done, write, folder, deck, verdict):
        """Makes the checks of every tenth and every twentieth scene."""
        options = self.options
        # Threads are used from 1000 elements on.
        parts = max(2, math.ceil(math.sqrt(1100 / max(scene.elements, 1))))
        small = verdict.increments * parts < 3_000
        if number % 10 == 0 and scene.elements and small:
            failure, compared = judge.same_on_two_threads(options.program, deck, folder, 6 * options.limit, parts)
            self.more["on two threads"] += compared
            verdict.failures += [failure] if failure else []
        # Mass scaling is computed again at the start of a step.
        can_split = scene.elements and "mass scaling" not in scene.features
        if number % 10 == 5 and done.code == judge.COMPLETE and can_split:
            failure, compared = judge.same_after_a_split(options.program, scene, done, write, folder, 6 * options.limit)
            self.more["with a split step"] += compared
            verdict.failures += [failure] if failure else []
        if number % 20 == 7:
            dice = random.Random(number)
            arguments = ["--mesh-refine", "2"] if scene.elements and verdict.increments < 2000 else []
            failure, killed = judge.same_after_a_kill(
                options.program, deck, folder, 6 * options.limit, dice, verdict.seconds, verdict.increments, arguments
            )
            self.more["killed and resumed"] += killed
            verdict.failures += [failure] if failure else []

    def save(self, number, scene, verdict, done):
        folder = os.path.join(self.options.out, "failures")
        os.makedirs(folder, exist_ok=True)
        name = f"{self.options.seed}_{number}"
        with open(os.path.join(folder, f"{name}.inp"), "w", encoding="utf-8") as file:
            file.write(scene.deck())
        reasons = verdict.failures or ["refused"]
        with open(os.path.join(folder, f"{name}.txt"), "w", encoding="utf-8") as file:
            file.write(f"{scene.name}\n" + "".join(f"{reason}\n" for reason in reasons) + done.messages)
        if verdict.failures:
            self.failures.append((name, scene.name, verdict.failures))
            print(f"scene {number} ({scene.name}): {'; '.join(verdict.failures)}", flush=True)

    def table(self, seconds):
        # Fewer than requested after SIGINT.
        count = self.counts.total()
        print(
            f"\n## Random scenes\n\nSeed {self.options.seed}, {count} scenes, {self.increments} increments, {seconds:.0f} s\n"
        )
        print("| result | scenes |\n|---|---|")
        for kind in KINDS:
            print(f"| {kind} | {self.counts[kind]} |")
        print("\n| further check | scenes |\n|---|---|")
        for name, value in self.more.items():
            print(f"| {name} | {value} |")
        print("\n| warning | scenes |\n|---|---|")
        for name, value in sorted(self.warnings.items()):
            print(f"| {name} | {value} |")
        print("\n| feature | scenes |\n|---|---|")
        for name, value in sorted(self.features.items()):
            print(f"| {name} | {value} |")
        if self.failures:
            print("\n| scene | failure |\n|---|---|")
            for name, text, reasons in self.failures:
                print(f"| {name}: {text} | {'; '.join(reasons)} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int, help="number of random scenes")
    parser.add_argument("seed", type=int, nargs="?", default=1)
    parser.add_argument("--program", required=True, help="the program to check")
    parser.add_argument("--out", required=True, help="folder for failures")
    parser.add_argument("--limit", type=float, default=60.0, help="time limit of a scene in seconds")
    parser.add_argument("--first", type=int, default=0, help="number of the first scene")
    parser.add_argument(
        "--kills", type=int, default=0, help="number of kills of sweep, study, limit, identify and scatter"
    )
    parser.add_argument("--growth", action="store_true", help="measure the growth of run time with the number of cards")
    parser.add_argument("--keep-refused", action="store_true", help="save the decks of refused scenes")
    options = parser.parse_args()
    os.makedirs(options.out, exist_ok=True)
    failed = False
    if options.count:
        soak, begin = Soak(options), time.monotonic()
        with contextlib.suppress(KeyboardInterrupt):
            for number in range(options.first, options.first + options.count):
                soak.check(number)
        soak.table(time.monotonic() - begin)
        failed |= bool(soak.failures)
    if options.kills:
        failed |= kills.report(options.program, options.kills, options.seed)
    if options.growth:
        growth.report(options.program)
    shutil.rmtree(os.path.join(options.out, "tmp"), ignore_errors=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
