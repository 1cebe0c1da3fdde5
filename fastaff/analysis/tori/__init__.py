"""Action-angle variables: of bodies that separate in closed form and by quadrature, of others by fits."""
