"""Last step from a recording to an episode: it becomes one of the data set's, or would become one."""

from pathlib import Path

from navtool.base.lineage import file_sha256
from navtool.base.note import Note
from navtool.base.plain import plain_fields
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.foreseen import Foreseen
from navtool.datasets.ingest.join_step import Joined
from navtool.datasets.ingest.output_errors import output_errors
from navtool.datasets.ingest.plan import EpisodePlan
from navtool.datasets.ingest.plan_step import Planned
from navtool.datasets.ingest.provenance import description_of, provenance_of
from navtool.datasets.ingest.report import EpisodeSummary
from navtool.datasets.recording.identity import source_name
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.renumber import renumber
from navtool.datasets.store.schema import IMAGE_KEY, features_of, video_keys
from navtool.datasets.store.writer import Store


def add_episode(
    store: Store, path: Path, planned: Planned, joined: Joined, robot: RobotConfig, config: IngestConfig
) -> EpisodeSummary:
    """Make a joined recording an episode of the data set, instead of an older one of the same recording.

    Raises:
        OutputError: A file cannot be written; the data set is then as it was.
    """
    plan = planned.plan
    replaced = store.episode_from(source_name(path), planned.sha256, plan.recording_start_ns)
    with output_errors(joined.folder.root):
        folder = renumber(joined.folder, store.numbering(replaced), plan.contents)
    provenance = provenance_of(path, planned, robot, config)
    hashes = {key: file_sha256(folder.video(key)) for key in video_keys(features_of(plan.contents))}
    if IMAGE_KEY in hashes:
        provenance["video_sha256"] = hashes.pop(IMAGE_KEY)
    if hashes:
        provenance["further_videos_sha256"] = hashes
    notes = joined.notes
    if replaced is None:
        store.commit(folder, description_of(plan, robot, config), provenance)
    else:
        store.replace(folder, provenance)
        what = "in the place of an older episode; labels were taken away: run `navtool label` again"
        notes = [*notes, Note("episode.replaced", what)]
    return _summary(
        plan,
        path,
        folder.numbering.episode_index,
        dropped=joined.dropped,
        notes=notes,
        rebuilt=replaced is not None,
    )


def foresee_episode(
    store: Foreseen, path: Path, planned: Planned, robot: RobotConfig, config: IngestConfig
) -> EpisodeSummary:
    """What adding a planned recording would do; nothing is written."""
    plan = planned.plan
    episode, rebuilt = store.foresee(
        description_of(plan, robot, config),
        provenance_of(path, planned, robot, config),
        int(plan.ticks_ns.size),
    )
    notes = [*plan.notes, *plan.odd.notes(), *plan.time_notes]
    if rebuilt:
        what = "would take the place of an older episode, whose labels would be taken away"
        notes.append(Note("episode.would-be-replaced", what))
    return _summary(plan, path, episode, dropped=plan.dropped, notes=notes, rebuilt=rebuilt)


def _summary(
    plan: EpisodePlan, path: Path, episode: int, *, dropped: dict[str, int], notes: list[Note], rebuilt: bool
) -> EpisodeSummary:
    return EpisodeSummary(
        episode=episode,
        source=source_name(path),
        rows=int(plan.ticks_ns.size),
        topics=dict(plan.topics.streams),
        not_used=[plain_fields(topic) for topic in plan.topics.not_used],
        dropped=dropped,
        sync=dict(plan.sync_report),
        notes=notes,
        rebuilt=rebuilt,
    )
