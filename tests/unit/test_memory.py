"""Memory predicted before anything is allocated."""

import math

import pytest
from small_scenes import RUBBER, grid, simulation

import mpmkit as mpm
from mpmkit._core.running import memory

pytestmark = pytest.mark.usefixtures("plain_python")


def ball(h=0.25, ppc=None, name=None, **more):
    return simulation(
        mpm.Grid((0.0,) * 3, (4.0,) * 3, h), mpm.Body(mpm.Sphere((2.0,) * 3, 1.0), RUBBER, particles_per_cell=ppc, name=name), **more
    )


def test_sum_of_the_parts():
    plan = ball().compose().plan
    needed, particles = memory.needed_bytes(plan)
    exact = ball().compose().n_particles
    assert abs(particles - exact) < 0.03 * exact  # an estimate, to some percent
    size = plan.composition.groups[0].layout.size
    assert needed["the fields of the particles"] == particles * 8 * size
    assert needed["sorting them"] == 16 * particles
    assert needed["a frame to be written"] == 0
    assert needed["two copies of the state"] == 2 * particles * 8 * size


def test_a_frame_counts_what_is_recorded(tmp_path):
    sim = ball()
    sim += mpm.Record(tmp_path / "a.vtkhdf")
    needed, particles = memory.needed_bytes(sim.compose().plan)
    assert needed["a frame to be written"] == particles * 4 * (3 + 3 + 6)


def test_too_little_is_refused_with_the_parts_and_the_ways_out():
    plan = ball().compose().plan
    needed, _ = memory.needed_bytes(plan)
    total = sum(needed.values())
    memory.check(plan, total)
    with pytest.raises(mpm.CompositionError) as caught:
        memory.check(plan, total - 1)
    text = str(caught.value)
    for part in (
        f"needs about {memory.text(total)}", "for the fields of the particles", "for the nodes", "are available",
        "coarser grid", "fewer particles_per_cell", 'precision="float32"',
    ):  # fmt: skip
        assert part in text
    with pytest.raises(mpm.CompositionError) as caught:
        memory.check(ball(precision="float32").compose().plan, 1000)
    assert "1 kB are available" in str(caught.value) and "float32" not in str(caught.value)


def test_refused_before_the_bodies_are_filled(monkeypatch):
    """A grid that is finer than meant: 1e15 particles; neither they nor a test of their positions would fit any machine."""
    monkeypatch.setattr(mpm.Body, "sample", lambda *_: pytest.fail("sampled"))
    with pytest.raises(mpm.CompositionError, match=r"about \d.*,\d{3},\d{3},\d{3},\d{3} particles .* are available"):
        ball(h=1e-4).compose()


@pytest.mark.parametrize("lattice", ["grid", "body"])
@pytest.mark.parametrize(
    ("geometry", "exact"),
    [(mpm.Box((0.5, 0.5), (1.5, 1.0)), 0.5), (mpm.Disk((1.0, 1.0), 0.5), math.pi / 4), (mpm.Box((0.0, 0.0), (1e-5, 1e-5)), None)],
)
def test_estimates_of_single_bodies(geometry, exact, lattice):
    g = grid("plane strain", cells=128, h=2.0 / 128)
    body = mpm.Body(geometry, RUBBER, lattice=lattice)
    if exact is None:
        assert body.estimated_count(g) <= 1
        return
    assert abs(body.estimated_count(g) / (exact / g.h**2 * 4) - 1) < 0.02  # an estimate
    assert abs(body.estimated_count(g) / body.sample(g).n - 1) < 0.02


def test_bodies_given_by_points_are_counted():
    assert mpm.Body.from_arrays([[0.5, 0.5], [0.6, 0.5]], 0.01, RUBBER).estimated_count(grid("plane strain")) == 2


# --- what there is ------------------------------------------------------------------------------------------------
def test_the_machine_has_some():
    assert memory.available_bytes() > 1 << 20


@pytest.mark.parametrize(
    ("line", "base", "names"),
    [
        ("0::/job/step\n", "", ("memory.max", "memory.current", "inactive_file")),
        ("4:cpu,memory:/job/step\n0::/other\n", "memory", ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")),
    ],
)
def test_limits_of_control_groups(tmp_path, line, base, names):
    """Of the group itself, and of those around it; both versions of the interface."""
    (tmp_path / "cgroup").write_text(line)
    inner, outer = tmp_path / base / "job" / "step", tmp_path / base / "job"
    inner.mkdir(parents=True)
    for folder, limit, used in ((inner, "max", 500), (outer, "5000", 1200)):
        (folder / names[0]).write_text(f"{limit}\n")
        (folder / names[1]).write_text(f"{used}\n")
        (folder / "memory.stat").write_text(f"anon 7\n{names[2]} 200\n")
    assert memory._of_groups(str(tmp_path), str(tmp_path / "cgroup")) == [5000 - 1200 + 200]
    assert memory._of_groups(str(tmp_path), str(tmp_path / "none")) == []


def test_units():
    assert [memory.text(n) for n in (999, 1500, 2_500_000, 3_210_000_000, 5 * 10**12)] == ["999 B", "1.5 kB", "2.5 MB", "3.21 GB", "5 TB"]
