"""A gallery on many machines: the workers of a Dask cluster hold a share each."""
