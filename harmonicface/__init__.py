"""Recognize faces under any lighting, and measure light and shape, with harmonic subspaces."""

from harmonicface.appearance.basis import harmonic_images
from harmonicface.appearance.choose import ModelChoice, choose_model
from harmonicface.appearance.inverse import LightEstimate, estimate_light
from harmonicface.appearance.principal import analytic_pca
from harmonicface.appearance.principal_components import PrincipalComponents
from harmonicface.appearance.relight import relight
from harmonicface.appearance.render import render
from harmonicface.appearance.sensor import photograph
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.gallery import Gallery
from harmonicface.gallery.match import Candidate, Match, SearchScores
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.rotation import rotate as rotate_harmonics
from harmonicface.io.depth_maps import read_depth_map
from harmonicface.io.images import read_image, write_image
from harmonicface.lighting import lights
from harmonicface.lighting.environment import EnvironmentMap
from harmonicface.lighting.light import HarmonicLight, Light
from harmonicface.lighting.prefiltered import irradiance_map, reflection_map
from harmonicface.people.ict import ict_people, ict_person
from harmonicface.people.prior import FacePrior, synthetic_prior
from harmonicface.people.synthetic import synthetic_people, synthetic_person
from harmonicface.recognition.exemplar import exemplar
from harmonicface.recognition.subspace import Subspace
from harmonicface.recognition.verification import Verification, verify
from harmonicface.reflectance.filters import lambertian_filter
from harmonicface.reflectance.materials import Microfacet, Phong
from harmonicface.reflectance.microfacet import microfacet_filter
from harmonicface.reflectance.phong import phong_filter
from harmonicface.stereo.depth.integration import integrate_normals
from harmonicface.stereo.photometric_stereo import photometric_stereo
from harmonicface.stereo.reconstruction import reconstruct
from harmonicface.stereo.registration import Registration, register
from harmonicface.stereo.result import Ambiguity, StereoResult
from harmonicface.surfaces.depth import surface_from_depth
from harmonicface.surfaces.load import load_surface, surface_from_normals
from harmonicface.surfaces.operations import crop, decimate, resize
from harmonicface.surfaces.pictures import surface_pictures
from harmonicface.surfaces.points import surface_from_points
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.transfer import transport
from harmonicface.surfaces.transport import Transport
from harmonicface.surfaces.turning import turn

__version__ = "0.1.0"

__all__ = [
    "Ambiguity",
    "Candidate",
    "EnvironmentMap",
    "FacePrior",
    "Gallery",
    "HarmonicFaceError",
    "HarmonicLight",
    "Light",
    "LightEstimate",
    "Match",
    "Microfacet",
    "ModelChoice",
    "Phong",
    "PrincipalComponents",
    "Registration",
    "SearchScores",
    "StereoResult",
    "Subspace",
    "Surface",
    "Transport",
    "Verification",
    "__version__",
    "analytic_pca",
    "choose_model",
    "crop",
    "decimate",
    "estimate_light",
    "exemplar",
    "harmonic_images",
    "ict_people",
    "ict_person",
    "integrate_normals",
    "irradiance_map",
    "lambertian_filter",
    "lights",
    "load_surface",
    "microfacet_filter",
    "phong_filter",
    "photograph",
    "photometric_stereo",
    "read_depth_map",
    "read_image",
    "real_harmonics",
    "reconstruct",
    "reflection_map",
    "register",
    "relight",
    "render",
    "resize",
    "rotate_harmonics",
    "surface_from_depth",
    "surface_from_normals",
    "surface_from_points",
    "surface_pictures",
    "synthetic_people",
    "synthetic_person",
    "synthetic_prior",
    "transport",
    "turn",
    "verify",
    "write_image",
]
