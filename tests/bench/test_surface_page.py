"""The page of a Surface: it stands alone and says what the Surface is."""

from __future__ import annotations

import base64
import io
import math
import re
from html.parser import HTMLParser

import numpy as np
from PIL import Image

import harmonicface as hf
from harmonicface.bench.light_table import light_table, usual_lights
from harmonicface.bench.surface_page import facts, sky_picture, sky_share, surface_page
from harmonicface.io.meshes import Mesh
from harmonicface.surfaces.mesh import surface_from_mesh

PERSON = hf.synthetic_person(3, 24)


class Page(HTMLParser):
    """Collects tags, addresses, what pictures are called, and all text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.pictures: dict[str, bytes] = {}
        self.links: list[str] = []
        self.text = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        named = dict(attrs)
        if tag == "img":
            kind, data = (named["src"] or "").split(",", 1)
            assert kind == "data:image/png;base64"
            self.pictures[named["alt"] or ""] = base64.b64decode(data, validate=True)
        self.links += [value or "" for name, value in attrs if name in ("href", "data", "action", "poster", "srcset")]

    def handle_data(self, data: str) -> None:
        self.text += data


def made(surface: hf.Surface = PERSON, order: int = 2, shadows: bool = False, bounces: int = 0) -> Page:
    images = hf.harmonic_images(surface, order, shadows, bounces)
    names = [f"harmonic_{index}.png" for index in range(len(images))]
    text = surface_page(surface, "<Ada> & $1", images, shadows, bounces, [*names, "mask.png"])
    assert "<title>&lt;Ada&gt; &amp; $1</title>" in text
    assert "<h1>&lt;Ada&gt; &amp; $1</h1>" in text
    assert not re.search(r"\$[a-z]", text)  # nothing was left unfilled
    assert not re.search(r"https?://|@import|url\(", text)
    page = Page(text)
    assert not {"script", "link", "iframe", "object", "embed"} & set(page.tags)
    assert page.links == []
    return page


def test_the_page_shows_everything_and_needs_nothing() -> None:
    page = made()
    named = {f"l = {degree}, m = {mode}" for degree in range(3) for mode in range(-degree, degree + 1)}
    lit = {f"{kind}: {name}" for kind in ("ball", "exact", "order 2", "error at order 2") for name in usual_lights()}
    assert set(page.pictures) == {"normals", "albedo", "depth", "mask", "colours"} | named | lit
    for png in page.pictures.values():
        assert png.startswith(b"\x89PNG")
    assert "24 \N{MULTIPLICATION SIGN} 24 pixels" in page.text
    assert "9 harmonic images" in page.text
    assert "cast shadows are not" in page.text
    assert "ambient occlusion" not in page.text
    assert "harmonic_0.png to harmonic_8.png, mask.png" in page.text
    assert "m = -2 · xy" in page.text


def test_shadows_are_shown_beside_what_they_change() -> None:
    page = made(order=3, shadows=True)
    assert "What cast shadows change" in page.text
    assert "Cast shadows are in them." in page.text
    assert "past what casts shadows" in page.text
    assert "zero" not in page.text
    share = 100 * sky_share(PERSON).mean()
    assert f"A pixel sees {share:.0f} % of the sky" in page.text
    attached, shadowed = hf.harmonic_images(PERSON, 3), hf.harmonic_images(PERSON, 3, shadows=True)
    percent = 100 * np.linalg.norm(shadowed - attached) / np.linalg.norm(shadowed)
    assert f"{percent:.1f} % of the former" in page.text
    picture = np.asarray(Image.open(io.BytesIO(page.pictures["ambient occlusion"])))
    np.testing.assert_array_equal(picture, np.rint(255 * sky_picture(PERSON)))
    assert "order 3: natural light" in page.pictures


def test_bounces_imply_shadows_and_are_counted() -> None:
    text = made(order=1, bounces=2).text
    assert "and light that is thrown back twice." in text
    assert "What cast shadows and light that is thrown back change" in text
    assert "What cast shadows change" not in text


def test_odd_degrees_are_explained_where_they_are_zero() -> None:
    assert "Odd degrees above 1 are zero" in made(order=3).text
    page = made(order=3)
    assert "up to 0m = -3" in page.text.replace("\n", "")


def test_a_surface_without_depth_or_light() -> None:
    black = hf.Surface(PERSON.normals, 0 * PERSON.albedo, PERSON.mask)
    page = made(black)
    assert "depth" not in page.pictures
    assert "0.0 %" in page.text


def test_black_skin_with_shadows_changes_nothing() -> None:
    black = hf.Surface(PERSON.normals, 0 * PERSON.albedo, PERSON.mask, PERSON.depth, PERSON.pixel_size)
    assert "0.0 % of the former" in made(black, order=1, shadows=True).text


def test_the_facts() -> None:
    normals = np.tile([0.0, 0.0, 1.0], (2, 4, 1))
    normals[0, 0] = [math.sin(math.radians(75.1)), 0, math.cos(math.radians(75.1))]
    normals[0, 1] = [math.sin(math.radians(74.9)), 0, math.cos(math.radians(74.9))]
    albedo = np.full((2, 4, 3), 0.5)
    albedo[1, 1] = 0.25
    found = facts(hf.Surface(normals, albedo, depth=np.arange(8.0).reshape(2, 4) - 3, pixel_size=0.5))
    assert found == {
        "pixel": "0.5 world units; the picture is 2 by 1",
        "depth": "-3 to 4 world units, 7 from back to front",
        "albedo": "0.25 to 0.5, mean 0.469, colour (numbers are its luminance)",
        "normals": "12.5 % graze: more than 75° from the camera",
    }


def test_a_mesh_is_counted() -> None:
    square = Mesh(
        np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]),
        np.tile([[0, 1, 2], [0, 2, 3]], (600, 1)),
        np.tile([0.0, 0, 1], (4, 1)),
        None,
        (),
        np.full(1200, -1),
        np.full((4, 3), 0.5),
    )
    assert facts(surface_from_mesh(square, 4))["mesh"] == "4 vertices, 1 200 triangles"


def test_the_sky_over_a_corner() -> None:
    size = 64
    depth = np.zeros((size, size))
    depth[:, : size // 2] = 1e3  # a wall as good as infinite
    floor = hf.Surface(np.tile([0.0, 0, 1], (size, size, 1)), np.ones((size, size)), depth=depth)
    share = np.zeros(floor.shape)
    share[floor.mask] = sky_share(floor)
    distance = np.arange(size // 2) + 0.5
    hidden = np.arctan(size / 2 / distance) / np.pi  # the wall is as high as the sky, so only its width counts
    error = share[size // 2, size // 2 :] - (1 - hidden)
    assert np.abs(error).max() < 1 / 32  # one azimuth of those that are sampled
    assert abs(error.mean()) < 0.01
    assert share[size // 2, : size // 4].min() > 0.99
    assert sky_picture(floor).max() <= 1


def test_errors_in_the_table_are_those_of_the_pictures() -> None:
    text = light_table(PERSON, 4, False, 0)
    errors = [float(number) for number in re.findall(r">(\d+\.\d) %</td>", text)]
    expected = []
    for light in usual_lights().values():
        exact = hf.render(PERSON, light)
        found = [hf.render(PERSON, light, order=order) for order in (2, 4)]
        expected += [100 * np.linalg.norm(picture - exact) / np.linalg.norm(exact) for picture in found]
    np.testing.assert_allclose(errors, expected, atol=0.05)
    assert errors[4] == errors[5] == 0  # nine coefficients are all that is known of it
    assert errors[1] < errors[0] and errors[3] < errors[2] and errors[7] < errors[6]
    assert "order 1" in light_table(PERSON, 1, False, 0)
