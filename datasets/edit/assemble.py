"""Episodes of data sets as a data set of their own: what deleting, splitting and merging have in common."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from navtool.base.errors import DatasetsError
from navtool.base.files import write_json
from navtool.base.plain import flatten, plain_fields
from navtool.base.progress import Progress
from navtool.datasets.edit.new_data_set import EditReport, copy_file, copy_folder, counted, new_folder, refuse_there
from navtool.datasets.labels.summary import joint_summary
from navtool.datasets.store.layout import Layout
from navtool.datasets.store.reader import Episode, NavDataset
from navtool.datasets.store.renumber import renumber
from navtool.datasets.store.replace import entry_stats
from navtool.datasets.store.schema import video_keys
from navtool.datasets.store.staged_episode import EpisodeFolder, Numbering
from navtool.datasets.store.writer import Store, open_store

type Chosen = tuple[NavDataset, Episode]


def without_episodes(dataset: NavDataset, episodes: Iterable[int], out: Path, progress: Progress | None) -> EditReport:
    """A data set without some of its episodes, as ingest would have made it without their recordings.

    Raises:
        DatasetsError: There is no such episode, none is left, or something is in the folder already.
        OutputError: It cannot be written.
    """
    gone = {episode.index for episode in _episodes_of(dataset, episodes)}
    return assemble([(dataset, episode) for episode in dataset.episodes if episode.index not in gone], out, progress)


def in_parts(
    dataset: NavDataset, parts: Mapping[str, Iterable[int]], out: Path, progress: Progress | None
) -> list[EditReport]:
    """Data sets of some of a data set's episodes each, in folders of ``out`` that are called as the parts are.

    Raises:
        DatasetsError: There is no such episode, one is in two parts, or something is in a folder already.
        OutputError: One cannot be written; those before it are whole.
    """
    chosen = {name: _episodes_of(dataset, episodes) for name, episodes in parts.items()}
    numbers = [episode.index for of_part in chosen.values() for episode in of_part]
    if twice := sorted({number for number in numbers if numbers.count(number) > 1}):
        what = f"episodes {', '.join(map(str, twice))} are named twice"
        raise DatasetsError(what, where=dataset.root, cure="name each in one part")
    for name in chosen:
        refuse_there(out / name)
    return [assemble([(dataset, e) for e in of_part], out / name, progress) for name, of_part in chosen.items()]


def together(datasets: Sequence[NavDataset], out: Path, progress: Progress | None) -> EditReport:
    """The episodes of several data sets, one after the other, as one.

    Raises:
        DatasetsError: They were made or labelled with other settings, share a recording, or the folder is not empty.
        OutputError: It cannot be written.
    """
    return assemble([(dataset, episode) for dataset in datasets for episode in dataset.episodes], out, progress)


def assemble(chosen: Sequence[Chosen], out: Path, progress: Progress | None = None) -> EditReport:
    """A data set of these episodes in this order: rows, videos and all that lies beside them.

    Files are the same to the byte as if ingest had made it of these recordings alone.

    Raises:
        DatasetsError: No episode is chosen, or they do not go together.
        OutputError: It cannot be written; nothing is left then.
    """
    if not chosen:
        raise DatasetsError("no episode is left", where=out, cure="keep at least one")
    _refuse_unlike([dataset for dataset, _ in chosen])
    _refuse_shared(chosen)
    labels = joint_summary([(dataset, slice(episode.start, episode.stop)) for dataset, episode in chosen])
    count = counted(progress, len(chosen))
    with new_folder(out) as staging:
        with open_store(staging) as store:
            for dataset, episode in chosen:
                folder = renumber(_copied(store, dataset, episode), store.numbering(None), dataset.description.contents)
                store.commit(folder, chosen[0][0].description, dataset.provenance_of(episode.index))
                count(episode.source)
            report = EditReport(str(out), store.episodes, store.rows)
        if labels is not None:
            write_json(Layout(staging).beside / "labels.json", labels)
    return report


def _copied(store: Store, dataset: NavDataset, episode: Episode) -> EpisodeFolder:
    """An episode's files in the store's staging folder, numbered as they were."""
    layout, number = dataset.layout, episode.index
    stats = entry_stats(layout.episode_meta(number))
    folder = EpisodeFolder(store.layout.staging, Numbering(number, episode.start), len(episode), stats)
    folder.root.mkdir(parents=True, exist_ok=True)
    copy_file(layout.data(number), folder.data)
    for key in video_keys(dataset.features):
        copy_file(layout.video(number, key), folder.video(key))
    copy_folder(layout.episode(number), folder.beside)
    return folder


def _episodes_of(dataset: NavDataset, numbers: Iterable[int]) -> list[Episode]:
    wanted = sorted(set(numbers))
    if unknown := [number for number in wanted if not 0 <= number < len(dataset.episodes)]:
        what = f"there is no episode {', '.join(map(str, unknown))}"
        raise DatasetsError(what, where=dataset.root, cure=f"it has 0 to {len(dataset.episodes) - 1}")
    return [dataset.episodes[number] for number in wanted]


def _refuse_unlike(datasets: Sequence[NavDataset]) -> None:
    """One data set has one rate, one set of columns, one robot and one way of ingest."""
    first = datasets[0]
    there = _settings(first)
    for other in dict.fromkeys(datasets):
        found = _settings(other)
        differ = [key for key in {**there, **found} if there.get(key) != found.get(key)]
        if differ:
            named = "; ".join(f"{key} is {found.get(key)}, {there.get(key)} in {first.root}" for key in differ[:4])
            cure = "ingest both with the same settings, `--allow-missing` for streams that one lacks"
            raise DatasetsError(named, where=other.root, cure=cure)


def _settings(dataset: NavDataset) -> dict[str, object]:
    made = dataset.description
    robot = {f"robot.{key}": made.robot.get(key) for key in ("name", "task")}
    ingest = {f"ingest.{key}": value for key, value in flatten(made.ingest).items() if key != "place"}
    return {f"contents.{key}": value for key, value in plain_fields(made.contents).items()} | robot | ingest


def _refuse_shared(chosen: Sequence[Chosen]) -> None:
    seen: dict[str, NavDataset] = {}
    for dataset, episode in chosen:
        sha256 = str(dataset.provenance_of(episode.index)["sha256"])
        if sha256 in seen:
            what = f"{episode.source} is in {seen[sha256].root} too"
            raise DatasetsError(what, where=dataset.root, cure="delete it from one of them first")
        seen[sha256] = dataset
