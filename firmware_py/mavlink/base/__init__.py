"""What all services share: codec, message definitions, scaling, modes, identity, signing, link settings."""
