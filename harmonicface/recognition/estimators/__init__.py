"""Every method of the comparison as a scikit-learn classifier, one a file; `registry` has them by name."""
