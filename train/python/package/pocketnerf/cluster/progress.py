"""Progress of all tasks: one bar, and the caller's function."""

from __future__ import annotations

from typing import Any, Callable, Dict, Mapping, Optional

from pocketnerf._run import bars

OnProgress = Callable[[str, Any], object]


class Watch:
    """Shows how many tasks are done. Those under way count by their steps, if these are known."""

    def __init__(
        self, total: int, unit: str, progress: Optional[bool], on_progress: Optional[OnProgress]
    ) -> None:
        self._on_progress = on_progress
        self._done = 0
        self._failed = 0
        self._shares: Dict[str, float] = {}
        self._bar: Any = None
        tqdm = bars(progress)
        if tqdm is None:
            return
        self._bar = tqdm(
            total=total,
            unit=unit,
            bar_format="{l_bar}{bar}| {n:.1f}/{total} [{elapsed}<{remaining}{postfix}]",
        )

    def news(self, news: Mapping[str, Any]) -> None:
        """Takes the latest progress of some tasks."""
        for name, progress in news.items():
            known = progress.steps and progress.phase == "training"
            self._shares[name] = progress.step / progress.steps if known else 0.0
        self._draw()
        if self._on_progress is not None:
            for name, progress in news.items():
                self._on_progress(name, progress)

    def finished(self, name: str, failed: bool) -> None:
        self._shares.pop(name, None)
        self._done += 1
        self._failed += failed
        self._draw()

    def _draw(self) -> None:
        if self._bar is not None:
            self._bar.set_postfix({"running": len(self._shares), "failed": self._failed}, False)
            self._bar.update(self._done + sum(self._shares.values()) - self._bar.n)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()
